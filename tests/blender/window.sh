#!/bin/sh
# Blender's window on a virtual screen, with the add-on from a zip in a throw-away user folder, driven by a script.
#
#   sh window.sh FOLDER BLENDER...
#
# FOLDER holds extension.zip and tests/; what Blender, the script and the virtual screen leave goes there too.
set -eu
folder=$1
shift
mkdir -p "$folder/user" "$folder/runtime" "$folder/pictures"
chmod 700 "$folder/runtime"
export HOME="$folder" XDG_RUNTIME_DIR="$folder/runtime" BLENDER_USER_RESOURCES="$folder/user" TMPDIR="$folder"
export LIBGL_ALWAYS_SOFTWARE=1 PYTHONDONTWRITEBYTECODE=1

"$@" --background --command extension install-file --repo user_default --enable "$folder/extension.zip" >"$folder/install.log" 2>&1 || {
    cat "$folder/install.log" >&2
    exit 3
}

mkfifo "$folder/display"
Xvfb -displayfd 3 -screen 0 1600x1000x24 +extension GLX -nolisten tcp 3<>"$folder/display" >"$folder/screen.log" 2>&1 &
screen=$!
trap 'kill "$screen"' EXIT
read -r number <"$folder/display"
export DISPLAY=":$number"
"$@" --gpu-backend opengl --enable-event-simulate --window-geometry 0 0 1600 1000 --python-exit-code 1 \
    --python "$folder/tests/drive.py" -- "$folder" $SCENES 2>&1 | tee "$folder/blender.log"
