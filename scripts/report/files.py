"""Files that appear whole or not at all, as those of the C++ programs do."""
import os
import tempfile

# A text of PNG, with its length and checksum, before the last chunk: diffsac_pair and diffsac_prepare pass over what has it.
_OWN = b"\0\0\0\x28tEXtSoftware\0drawn by DiffSAC, no photograph\xed\x88\x17\xcf"
_PNG_END = b"\0\0\0\0IEND\xae\x42\x60\x82"


def write_whole(path, content):
    """Text or bytes through a hidden temporary file beside it."""
    data = content.encode() if isinstance(content, str) else content
    folder, name = os.path.split(os.path.abspath(path))
    handle, temporary = tempfile.mkstemp(prefix=f".{name}.", dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def marked_as_own(png):
    assert png.endswith(_PNG_END)
    return png[: -len(_PNG_END)] + _OWN + _PNG_END


def remove(path):
    try:
        os.unlink(path)
    except FileNotFoundError:
        pass
