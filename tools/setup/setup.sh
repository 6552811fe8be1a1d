#!/usr/bin/env bash
# Installs what the project needs and is not there: FreeFEM and shared libraries with
# apt-get (as root or through sudo), Python packages into .venv. A second call does
# nothing and takes milliseconds. Called by make; needs bash and python3 >= 3.10.
#
#   tools/setup/setup.sh            install what is missing
#   tools/setup/setup.sh --check    say what is missing, install nothing (status 1 if something is)
#
# Elsewhere than on Linux, Debian's packages are not asked for: FreeFEM and Python must be there
# (docs/guide/other_machines.md). In a conda environment its own libraries count.
#
# Environment: FREEFEM (the program, default FreeFem++), PYTHON (default python3).
# Ends with status 1 and one line that names what is missing and the command for it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

freefem=${FREEFEM:-FreeFem++}
python=${PYTHON:-python3}
# In an activated .venv that is the copy in .venv itself: the one it was made from is meant.
if [[ $(command -v "$python") == "$PWD/.venv/"* ]]; then
    python=$("$python" -c "import sys; print(sys._base_executable)" 2>/dev/null || echo /usr/bin/python3)
fi
stamp=.venv/complete
system=$(uname -s 2>/dev/null || echo Linux)
freefem_packages="freefem++ libfreefem++ libfreefem++-dev libopenblas0-pthread"
# soname and package of each library the gmsh wheel links to
gmsh_libraries="libGLU.so.1:libglu1-mesa libGL.so.1:libgl1 libXrender.so.1:libxrender1
    libXcursor.so.1:libxcursor1 libXfixes.so.3:libxfixes3 libXext.so.6:libxext6
    libXft.so.2:libxft2 libfontconfig.so.1:libfontconfig1 libXinerama.so.1:libxinerama1
    libX11.so.6:libx11-6 libgomp.so.1:libgomp1"

fail() {
    echo "setup: $*" >&2
    exit 1
}

has() { command -v "$1" >/dev/null 2>&1; }

# Debian packages that are missing, on one line; elsewhere than on Linux, programs.
missing_packages() {
    local missing="" pair libraries package
    if [[ $system != Linux ]]; then
        has "$freefem" || missing="FreeFEM ($freefem)"
        "$python" -c "import ensurepip, venv" 2>/dev/null || missing="${missing:+$missing, }Python's venv module"
        echo "$missing"
        return
    fi
    if ! has "$freefem"; then
        missing="$freefem_packages"
    elif has dpkg-query && dpkg-query -S "$(command -v "$freefem")" >/dev/null 2>&1; then
        # A FreeFEM of the system needs its other packages; one built from source has its own.
        for package in $freefem_packages; do
            dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q "ok installed" || missing="$missing $package"
        done
    fi
    "$python" -c "import ensurepip, venv" 2>/dev/null || missing="$missing python3-venv"
    libraries=$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null || true)
    for pair in $gmsh_libraries; do
        [[ $libraries == *"${pair%%:*} "* || -n ${CONDA_PREFIX:-} && -e ${CONDA_PREFIX:-}/lib/${pair%%:*} ]] || missing="$missing ${pair##*:}"
    done
    echo $missing
}

# What the virtual environment was made from: the pins, the interpreter and this folder.
fingerprint() {
    { cat tools/setup/requirements.txt; "$python" -c "import os, sys; print(sys.version, os.path.realpath(sys._base_executable))"; pwd -P; } |
        if has sha256sum; then sha256sum; else shasum -a 256; fi | cut -c1-64
}

environment_is_complete() {
    [[ -x .venv/bin/python && -f $stamp && $(<"$stamp") == "$(fingerprint)" ]]
}

install_packages() {
    local packages=$1 sudo="" log command
    command="apt-get update && apt-get install -y $packages"
    [[ $system == Linux ]] || fail "missing: $packages; on $system this cannot be installed from here: docs/guide/other_machines.md says what runs where"
    has apt-get || fail "missing: $packages (names of Debian packages; there is no apt-get here): install FreeFEM 4.9 or newer, Python's venv module and these libraries, then run make setup again"
    if [[ $(id -u) != 0 ]]; then
        if has sudo && { sudo -n true 2>/dev/null || [[ -t 0 ]]; }; then
            sudo="sudo"
        elif [[ ${packages// /} == libopenblas0-pthread ]]; then
            echo "setup: libopenblas0-pthread, a faster BLAS, is not installed and cannot be without root; all runs without it" >&2
            return
        else
            fail "missing: $packages, and neither root nor sudo is at hand: ask an administrator to run: $command"
        fi
    fi
    echo "setup: installing $packages"
    log=$(mktemp)
    # A package list that could not be renewed is no fault yet: the next line tells.
    $sudo apt-get -qq -o DPkg::Lock::Timeout=120 update >"$log" 2>&1 || true
    if ! $sudo env DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o DPkg::Lock::Timeout=120 \
        install --no-install-recommends $packages >>"$log" 2>&1; then
        grep -E "^(E|Err)" "$log" | head -n 3 >&2 || true
        fail "missing: $packages; could not be installed (no network? whole log: $log); the command is: $command"
    fi
    rm -f "$log"
    hash -r
}

make_environment() {
    local log
    "$python" -c "import sys; sys.exit(sys.version_info < (3, 10))" || fail "$python ($("$python" --version 2>&1 | head -n 1)) cannot be used: Python 3.10 or newer is needed (name it with PYTHON=python3.x)"
    echo "setup: installing the Python packages of tools/setup/requirements.txt into .venv"
    if [[ -L .venv ]]; then rm .venv; fi # somebody else's: clearing it would reach through the link
    log=$(mktemp)
    rm -f "$stamp"
    if ! "$python" -m venv --clear .venv >"$log" 2>&1; then
        tail -n 3 "$log" >&2
        fail "missing: a virtual environment; $python -m venv .venv failed (log: $log); on Debian: apt-get install -y python3-venv"
    fi
    if ! .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-input \
        -r tools/setup/requirements.txt >>"$log" 2>&1; then
        grep -E "^ERROR" "$log" | head -n 2 >&2 || true
        fail "missing: Python packages; pip failed (no network? whole log: $log); the command is: .venv/bin/python -m pip install -r tools/setup/requirements.txt"
    fi
    .venv/bin/python -c "import gmsh" >>"$log" 2>&1 || {
        tail -n 1 "$log" >&2
        fail "missing: a shared library of gmsh (the line above)$([[ $system != Linux ]] || echo "; on Debian apt-file search NAME finds its package")"
    }
    fingerprint >"$stamp"
    rm -f "$log"
}

if [[ ${1:-} == --check ]]; then
    packages=$(missing_packages)
    [[ -z $packages ]] || echo "missing: $packages"
    environment_is_complete || echo "missing: Python packages of tools/setup/requirements.txt in .venv"
    [[ -z $packages ]] && environment_is_complete
    exit
fi
[[ $# == 0 ]] || fail "unknown argument '$1' (only --check is known)"
has "$python" || fail "missing: $python; the command is: apt-get install -y python3 python3-venv"

# Two calls at the same time would spoil each other: the second waits.
if has flock; then
    exec 9>.setup.lock
    flock 9
fi
if [[ ! -f $stamp ]] || ! has "$freefem" || ! environment_is_complete; then
    packages=$(missing_packages)
    [[ -z $packages ]] || install_packages "$packages"
    has "$freefem" || fail "missing: $freefem; it is not on the PATH although its packages are installed: name it with FREEFEM=/path/to/FreeFem++"
    environment_is_complete || make_environment
fi
# So that python -m tools.NAME of .venv finds the tools from any folder.
for packages in .venv/lib/python3*/site-packages; do
    [[ ! -d $packages || -f $packages/project.pth ]] || pwd -P >"$packages/project.pth"
done
