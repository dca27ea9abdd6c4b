#!/bin/sh
#SBATCH --requeue --signal=TERM@60 --cpus-per-task=16
# A picture on a Slurm cluster: the tasks of a job array render runs of its samples, a job after them puts the picture together.
#
#   SCENE=scene.xml SPP=4096 TASKS=64 sh contrib/slurm.sh           # submits all tasks and the merge
#   SCENE=scene.xml SPP=4096 TASKS=64 sh contrib/slurm.sh missing   # submits the tasks of which something is missing
#
# A task that is killed goes on from its checkpoint when it is requeued or submitted again. PARTS is a folder that all nodes see.
set -eu
: "${SCENE:?}" "${SPP:?}" "${TASKS:?}" "${PARTS:=parts}"
export SCENE SPP TASKS PARTS
mkdir -p "$PARTS"
first() { echo $(($1 * SPP / TASKS)); }

# The tasks whose samples the merge misses, as 3,17,18.
missing() {
    abbe merge --json --no-png -q -o "$PARTS/all.exr" "$PARTS"/*.checkpoint 2>/dev/null |
        jq -r --argjson spp "$SPP" --argjson tasks "$TASKS" '[.missing[].samples as [$a, $b] | range($tasks)
            | select(((. * $spp / $tasks | floor) < $b) and (((. + 1) * $spp / $tasks | floor) > $a))]
            | unique | map(tostring) | join(",")'
}

submit() {
    array=$(sbatch --parsable --array="$1" "$0" task)
    sbatch --dependency="afterany:$array" "$0" merge
}

case "${1:-all}" in
all) submit "0-$((TASKS - 1))" ;;
missing) submit "$(missing)" ;;
task)
    task=$SLURM_ARRAY_TASK_ID
    exec abbe render "$SCENE" --spp "$SPP" --samples "$(first "$task")..$(first $((task + 1)))" \
        --resume --threads "${SLURM_CPUS_PER_TASK:-1}" -o "$PARTS/$task.checkpoint"
    ;;
merge) abbe merge "$PARTS"/*.checkpoint -o "${OUT:-picture.exr}" ;;
esac
