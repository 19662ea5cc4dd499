#!/usr/bin/env bash
# Installs what is missing to build DiffSAC: Debian packages and LibTorch. Run it as often as you like: when nothing is
# missing it takes a moment and asks no server.
set -euo pipefail

readonly TORCH_VERSION=2.11.0
readonly TORCH_WHEELS=("torch==${TORCH_VERSION}" "nvidia-cuda-runtime==13.0.*" "nvidia-cuda-cupti==13.0.*")
# Only what the build and the programs use; apt-get brings what these need themselves.
readonly PACKAGES=(
  g++ cmake ninja-build ccache git pkg-config ca-certificates python3 python3-pip
  libeigen3-dev libhdf5-dev libyaml-cpp-dev libspdlog-dev libcli11-dev nlohmann-json3-dev libtbb-dev
  libopencv-core-dev libopencv-imgproc-dev libopencv-calib3d-dev catch2 libgloo-dev libnanoflann-dev
  libboost-dev libboost-graph-dev libopencv-features2d-dev libopencv-imgcodecs-dev libexif-dev liblensfun-dev libsqlite3-dev
  nettle-dev zlib1g-dev python3-matplotlib python3-jinja2 python3-pandas python3-h5py python3-yaml python3-scipy python3-pil
  fonts-dejavu-core)

usage() {
  cat <<'END'
usage: scripts/setup.sh [--prefix DIR]
  --prefix DIR   use the LibTorch in DIR (an unpacked LibTorch zip, or the torch folder of a Python installation) and
                 remember it in .deps/libtorch; remove that link to go back. The variable Torch_DIR does the same for
                 one command.
END
}

say() { echo "setup: $*"; }
fail() { echo "setup: $*" >&2; exit 1; }

is_installed() { [[ "$(dpkg-query -W -f='${Status}' "$1" 2>/dev/null)" == "install ok installed" ]]; }

install_packages() {
  local missing=() name
  if ! command -v dpkg-query >/dev/null; then
    say "no Debian packages here; your system must provide what these Debian packages hold: $*"
    return
  fi
  for name in "$@"; do is_installed "$name" || missing+=("$name"); done
  if ((${#missing[@]} == 0)); then return; fi

  local install=(apt-get install -y --no-install-recommends "${missing[@]}")
  local as_root=()
  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null || ! sudo -n true 2>/dev/null; then
      fail "packages are missing; run this, then start again:
  sudo apt-get update && sudo ${install[*]}"
    fi
    as_root=(sudo -n)
  fi
  say "installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive "${install[@]}"
}

# Prints the folder that holds LibTorch's include/ and lib/, given it, its share/cmake/Torch or the folder above.
find_libtorch() {
  local folder
  for folder in "$1" "$1/../../.." "$1/torch" "$1/libtorch"; do
    if [[ -f "$folder/include/torch/csrc/api/include/torch/torch.h" && -e "$folder/lib/libtorch_cpu.so" ]]; then
      (cd "$folder" && pwd -P)
      return
    fi
  done
  return 1
}

find_pip() {
  local python
  for python in python3 /usr/bin/python3; do
    if "$python" -m pip --version >/dev/null 2>&1; then
      echo "$python"
      return
    fi
  done
  return 1
}

# The wheel appears whole or not at all: pip fills a temporary folder that is renamed when it is complete.
install_wheel() {
  local target=".deps/torch-${TORCH_VERSION}" stamp="${TORCH_WHEELS[*]}" python
  if [[ -f "$target/diffsac-setup" && "$(<"$target/diffsac-setup")" == "$stamp" ]]; then return; fi
  python=$(find_pip) || fail "python3 with pip is needed to fetch LibTorch (or give --prefix DIR)"
  say "fetching LibTorch ${TORCH_VERSION} into $target (about 550 MB, 1.2 GB unpacked)"
  mkdir -p .deps
  temporary=$(mktemp -d ".deps/torch-${TORCH_VERSION}.part-XXXXXX")
  trap 'rm -rf "$temporary"' EXIT
  trap 'exit 130' INT TERM
  # The C++ libraries are the same in the wheel of every Python version, so the one asked for need not be installed.
  "$python" -m pip install --quiet --no-input --disable-pip-version-check --root-user-action=ignore --no-deps --no-compile \
    --only-binary=:all: --python-version 3.11 --target "$temporary" "${TORCH_WHEELS[@]}"
  find_libtorch "$temporary" >/dev/null || fail "the torch wheel holds no LibTorch for C++"
  echo "$stamp" >"$temporary/diffsac-setup"
  chmod 755 "$temporary"
  rm -rf "$target"
  mv "$temporary" "$target"
  trap - EXIT INT TERM
}

setup_libtorch() {
  local root
  if [[ -n "$prefix" ]]; then
    root=$(find_libtorch "$prefix") || fail "no LibTorch (include/torch, lib/libtorch_cpu.so) in $prefix"
    mkdir -p .deps
    ln -sfn "$root" .deps/libtorch
  elif [[ -n "${Torch_DIR:-}" ]]; then
    root=$(find_libtorch "$Torch_DIR") || fail "no LibTorch (include/torch, lib/libtorch_cpu.so) in Torch_DIR=$Torch_DIR"
  elif [[ -L .deps/libtorch ]]; then
    root=$(find_libtorch .deps/libtorch) || fail ".deps/libtorch points to no LibTorch; give --prefix DIR or remove it"
  else
    install_wheel
    root=".deps/torch-${TORCH_VERSION}/torch"
  fi
  say "ready; LibTorch in $root"
}

prefix=""
packages=("${PACKAGES[@]}")
# Its output differs from version to version; where the system has another, the format is not checked.
[[ ! -e /etc/debian_version || "$(</etc/debian_version)" != 12.* ]] || packages+=(clang-format-14)
while (($#)); do
  case "$1" in
    --prefix) [[ -n "${2:-}" ]] || fail "--prefix needs a folder"; prefix=$2; shift 2 ;;
    --prefix=*) prefix=${1#--prefix=}; shift ;;
    -h|--help) usage; exit 0 ;;
    *) usage >&2; fail "unknown option $1" ;;
  esac
done
# Relative folders mean the caller's, so they are resolved before the change of folder.
if [[ -n "$prefix" ]]; then
  prefix=$(cd "$prefix" 2>/dev/null && pwd -P) || fail "--prefix: no such folder"
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
install_packages "${packages[@]}"
setup_libtorch
