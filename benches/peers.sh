#!/usr/bin/env bash
# Compares the ray throughput of Embree, obvhs and Rayframe on the same scenes and rays, and prints Rayframe's speedup.
#
#   benches/peers.sh WORKDIR [SCENE...]
#
# Environment:
#   EMBREE         run_peer.sh, which builds the Embree program in WORKDIR, generates scenes and rays, measures, and appends to
#                  WORKDIR/peers.csv. Embree is skipped without it.
#   STORED         table of single-ray speeds with rows of tinybvh and obvhs-native. The speed of tinybvh is estimated from it.
#   ROUNDS         number of measuring rounds; the best of each figure counts (3)
#   OBVHS_ROUNDS   number of rounds that include obvhs, which takes longest (1)
#   OBVHS_PRESETS  presets of obvhs (all)
#   CSV            output file for all rows of this run, overwritten (WORKDIR/ratios.csv)
#
# obvhs selects SIMD at compile time, so it is measured in a second build for this machine (RUSTFLAGS='-C target-cpu=native', in
# target/native). Rayframe is measured in the portable build, as users get it.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,/^set/p' "$0" | sed '$d; s/^# \{0,1\}//'; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(cd "$1" && pwd); shift
scenes=${*:-bunny sponza kitchen arch stadium ico70k ico1m}
rows=$(realpath "${CSV:-$work/ratios.csv}")
: > "$rows"

bench() { (cd "$root" && cargo bench --quiet -p peers --bench tracers -- "$work" --csv "$rows" "$@"); }
native() { RUSTFLAGS='-C target-cpu=native' CARGO_TARGET_DIR="$root/target/native" bench "$@"; }

# Compile before measuring.
(cd "$root" && cargo bench --quiet --no-run -p peers --bench tracers)
if [ "${OBVHS_ROUNDS:-1}" -gt 0 ]; then
  (cd "$root" && RUSTFLAGS='-C target-cpu=native' CARGO_TARGET_DIR=target/native cargo bench --quiet --no-run -p peers --bench tracers)
fi

presets=()
for preset in ${OBVHS_PRESETS:-}; do presets+=(--config "$preset"); done

for round in $(seq "${ROUNDS:-3}"); do
  for scene in $scenes; do
    echo "round $round: $scene" >&2
    if [ -n "${EMBREE:-}" ]; then
      before=$(wc -l < "$work/peers.csv" 2>/dev/null || echo 0)
      "$EMBREE" "$work" "$scene" > /dev/null
      tail -n "+$((before + 1))" "$work/peers.csv" >> "$rows"
    fi
    bench --lib rayframe "$scene"
    if [ "$round" -le "${OBVHS_ROUNDS:-1}" ]; then native --lib obvhs "${presets[@]}" "$scene"; fi
  done
done

awk -f "$root/benches/peers/ratios.awk" ${STORED:+"$STORED"} "$rows"
