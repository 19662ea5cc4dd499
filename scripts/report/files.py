"""Files that appear whole or not at all, as those of the C++ programs do."""
import os
import re
import signal
import socket
import sys



class CannotWrite(Exception):
    """Names the file and the cause."""


class BadInput(Exception):
    """Names the file or folder, and what is wrong with it."""


def write_whole(path, content):
    """Text or bytes through a hidden temporary file beside it."""
    data = content.encode(errors="replace") if isinstance(content, str) else content
    folder, name = os.path.split(os.path.abspath(path))
    stem, extension = os.path.splitext(name)
    machine = re.sub("[^A-Za-z0-9]", "_", socket.gethostname())
    # As the programs name theirs (lab/files/files.h), which remove what killed processes left.
    temporary = os.path.join(folder, f".{stem[:100]}.tmp-{os.getpid()}-0-{machine}{extension}")
    try:
        with open(temporary, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise CannotWrite(f"cannot write {path}: {error.strerror}") from error
    finally:
        remove(temporary)


def remove(path):
    if os.path.lexists(path):
        os.unlink(path)


def run_script(main, *arguments):
    """Runs a script's main. Bad input is one line and status 2, a file that cannot be written one line and status 4. Ctrl-C ends it at once."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        sys.exit(main(*arguments))
    except (CannotWrite, BadInput, OSError) as error:
        print(f"{os.path.basename(sys.argv[0]).removesuffix('.py')}: {error}", file=sys.stderr)
        sys.exit(4 if isinstance(error, CannotWrite) else 2)
