#!/bin/sh
# A picture on several machines by GNU parallel: runs of its samples, then the merge. The same command again renders what is missing.
#
#   SCENE=scene.xml SPP=4096 TASKS=64 sh contrib/parallel.sh --sshloginfile hosts --workdir "$PWD"
#
# Arguments go to parallel. Without any all runs are rendered here, one after the other. PARTS is a folder that all machines see.
set -eu
: "${SCENE:?}" "${SPP:?}" "${TASKS:?}" "${PARTS:=parts}" "${OUT:=picture.exr}"
mkdir -p "$PARTS"

# One line a run: its number and its samples. Finished runs end at once, those that were killed go on.
seq 0 $((TASKS - 1)) | while read -r task; do
    echo "$task $((task * SPP / TASKS))..$(((task + 1) * SPP / TASKS))"
done | parallel --jobs 1 --retries 3 --colsep ' ' "$@" \
    abbe render "$SCENE" --spp "$SPP" --samples {2} --resume -q -o "$PARTS/{1}.checkpoint"

# Says what is missing, as options of abbe render, and ends with exit code 3 then.
abbe merge "$PARTS"/*.checkpoint -o "$OUT"
