#!/bin/sh
# Makes .venv with the pinned packages, or leaves it alone if it is up to date.
#
#   sh .ci/environment.sh                            what a run needs
#   sh .ci/environment.sh .ci/requirements-test.txt  and what this list names
#   VENV=.venv-batch sh .ci/environment.sh .ci/requirements-batch.txt   another, with what the list names alone
#   PYTHON=/path/to/python3.11 sh .ci/environment.sh
#
# Each problem is reported in one sentence, with the command that fixes it; the exit code is then 1.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$here")
venv=$root/${VENV:-.venv}
log=$venv/setup.log
needed_kb=2500000 # Blender as a module takes 1.3 GB, and its download is unpacked beside it

fail() {
    echo "$1" >&2
    exit 1
}

# The "3.11" of a Python that runs; nothing for one that does not (a pyenv shim exists and says "command not found").
version_of() {
    "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null || true
}

supported() {
    [ "$1" = 3.13 ] || [ "$1" = 3.11 ]
}

find_python() {
    if [ -n "${PYTHON:-}" ]; then
        version=$(version_of "$PYTHON")
        [ -n "$version" ] || fail "PYTHON=$PYTHON does not run; name a Python 3.11 or 3.13, for example: make demo PYTHON=/usr/bin/python3.11"
        supported "$version" || fail "PYTHON=$PYTHON is Python $version, and Blender as a module exists for 3.11 and 3.13 only; name one of those, for example: make demo PYTHON=/usr/bin/python3.11"
        python=$PYTHON
        return
    fi
    seen=
    for name in python3.13 python3.11 python3 python; do
        old_ifs=$IFS
        IFS=:
        for folder in $PATH; do
            [ -x "$folder/$name" ] || continue
            version=$(version_of "$folder/$name")
            if supported "$version"; then
                IFS=$old_ifs
                python=$folder/$name
                return
            fi
            [ -z "$version" ] || seen="$seen $version"
        done
        IFS=$old_ifs
    done
    fail "Python 3.11 or 3.13 is needed${seen:+ and only$seen was found}; install one (apt-get install python3.13 python3.13-venv, or python3.11 python3.11-venv) or name it: make demo PYTHON=/path/to/python3.13"
}

check_disk() {
    free_kb=$(df -Pk "$root" | awk 'NR == 2 { print $4 }')
    [ "$free_kb" -ge "$needed_kb" ] || fail "Only $((free_kb / 1000)) MB are free on the disk of $root and Blender as a module needs $((needed_kb / 1000)); make room there (see what is large: du -xsh $root/* ~/.cache) and run this again."
}

make_venv() {
    check_disk
    "$python" -c 'import ensurepip, venv' 2>/dev/null ||
        fail "$python has no venv module; install it: apt-get install python$version-venv"
    echo "Making ${venv##*/} with $python (once; up to half a gigabyte is fetched) ..." >&2
    rm -rf "$venv" && mkdir "$venv" 2>/dev/null || fail "$root cannot be written; copy the project to a folder of your own and run this there."
    "$python" -m venv "$venv" >"$log" 2>&1 ||
        fail "$python could not make $venv: $(tail -n 1 "$log")"
    mkdir -p "$venv/packages"
    ln -s ../.. "$venv/packages/origami"
}

# .venv keeps a copy of each installed list.
copy_of() {
    echo "$venv/installed/$(echo "$1" | tr / -)"
}

is_installed() {
    cmp -s "$root/$1" "$(copy_of "$1")"
}

note_installed() {
    mkdir -p "$venv/installed"
    cp "$root/$1" "$(copy_of "$1")"
}

install() {
    echo "Installing what $1 lists ..." >&2
    "$venv/bin/python" -m pip install --disable-pip-version-check --no-input --retries 2 --timeout 60 \
        -r "$root/$1" >"$log" 2>&1 || explain_pip
}

explain_pip() {
    again="then run this again"
    if grep -q "No space left on device" "$log"; then
        fail "The disk filled up while packages were installed; make room on the disk of $root and of ${TMPDIR:-/tmp} (df -h shows both; rm -rf ~/.cache/pip frees pip's cache), $again."
    fi
    if grep -qE "NewConnectionError|NameResolutionError|Max retries|ConnectTimeout|ReadTimeout|ProxyError|SSLError|Network is unreachable|name resolution" "$log"; then
        fail "The packages could not be fetched, the package index does not answer; connect this machine to the network (behind a proxy: export HTTPS_PROXY=http://host:port), $again."
    fi
    missing=$(sed -n 's/^ERROR: No matching distribution found for \([^ ]*\).*/\1/p' "$log" | head -n 1)
    if [ -n "$missing" ]; then
        fail "The package index has no $missing for this machine ($(uname -sm), Python $version); run this on Linux x86_64 with glibc 2.28 or newer, or look at $log."
    fi
    fail "pip could not install the packages: $(grep '^ERROR' "$log" | tail -n 1) (all of it: cat $log); rm -rf $venv, $again."
}

# Blender as a module links to libraries of the window system even where no window is ever opened.
check_libraries() {
    "$venv/bin/python" -c 'import bpy, pycolmap, scipy' >"$log" 2>&1 && return
    missing=$(sed -n 's/.*ImportError: \(lib[^ :]*\): cannot open shared object file.*/\1/p' "$log")
    if command -v ldd >/dev/null; then
        missing=$(find "$venv" -path '*/bpy/__init__*.so' -exec ldd {} + 2>/dev/null | awk '/not found/ { print $1 }'
            echo "$missing")
    fi
    missing=$(echo "$missing" | sort -u | grep . || true)
    [ -n "$missing" ] || fail "Blender as a module does not start: $(tail -n 1 "$log") (all of it: cat $log); rm -rf $venv and run this again."
    packages=
    for library in $missing; do
        package=$(awk -v library="$library" '$1 == library { print $2 }' "$here/system-libraries.txt")
        packages="$packages ${package:-"(the package with $library)"}"
    done
    # shellcheck disable=SC2086 # the names, one after the other on one line
    fail "Blender as a module needs system libraries that are missing here ($(echo $missing)); install them: apt-get install$packages"
}

if [ -n "${PYTHON:-}" ] || ! [ -x "$venv/bin/python" ]; then
    find_python
else
    version=$(version_of "$venv/bin/python")
    supported "$version" || find_python
fi

[ "$(version_of "$venv/bin/python")" = "$version" ] && [ -e "$venv/packages/origami" ] || make_venv

if [ "$venv" = "$root/.venv" ] && ! is_installed .ci/requirements.txt; then
    install .ci/requirements.txt
    check_libraries
    note_installed .ci/requirements.txt
fi
for list in "$@"; do
    if ! is_installed "$list"; then
        install "$list"
        note_installed "$list"
    fi
done
