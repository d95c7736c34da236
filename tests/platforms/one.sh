#!/bin/sh
# Builds and runs one platform, and writes the results to out/platforms/NAME/row.tsv and result.json.
# SPDX-License-Identifier: MIT
# usage: one.sh NAME JOBS quick|full [REFERENCE]    from the root of the tree. REFERENCE: the platform whose recordings
# are compared; default: this platform. quick: platform_check replaces the tool. Exits 0 if nothing differs.
set -u
name=$1
jobs=$2
extent=$3
reference=${4-$1}
out=out/platforms/$name
rm -rf "$out"
mkdir -p "$out" build
tab=$(printf '\t')

# json_value KEY FILE: the first scalar with that key.
json_value() {
  tr ',{}[]' '[\n*]' <"$2" | sed -n 's/^[[:space:]]*"'"$1"'"[[:space:]]*:[[:space:]]*"\{0,1\}\([^"]*\)"\{0,1\}[[:space:]]*$/\1/p' |
    head -n 1
}
json_text() { printf '%s' "$1" | tr -d '\r' | tr '\n\t' '  ' | sed 's/\\/\\\\/g; s/"/\\"/g'; }
# Ends an emulator that hangs, and counts it as a difference.
run() { timeout 1200 "build/$name/run" "$@"; }
program=platform_check
[ "$extent" = quick ] || program=ticktrue
tool() { run "$program" "$@"; }

# The first failure, for the table.
first=
find_fault() { [ -n "$first" ] || first=$1; printf 'FOUND: %s\n' "$1"; }

# User time of all child processes of this script, in hundredths of a second.
user_time() {
  sed -n '2s/^\([0-9]*\)m\([0-9]*\)[.,]\([0-9][0-9]\).*/\1 \2 \3/p' "$out/times" | awk '{ print $1 * 6000 + $2 * 100 + $3 }'
}
start_phase() {
  phase_wall=$(date +%s)
  times >"$out/times"
  phase_user=$(user_time)
}
end_phase() {
  times >"$out/times"
  wall=$(($(date +%s) - phase_wall))
  user=$(($(user_time) - phase_user))
  user="$((user / 100)).$(printf '%02d' $((user % 100)))"
}

# --- fused multiply-add ---------------------------------------------------------------------------------------------

# For each platform: its disassembler, the pattern of its fused instructions, and flags that make its compiler emit one.
# The flags test the pattern itself. Empty: the platform has no such instruction.
disassembler=objdump
contract='-ffp-contract=fast'
case $name in
  gcc | clang19) fused='vfn?m(add|sub)' contract='-ffp-contract=fast -mfma' ;;
  i386) fused='vfn?m(add|sub)' contract='-ffp-contract=fast -mfma -mfpmath=sse' ;;
  win64) disassembler=x86_64-w64-mingw32-objdump fused='vfn?m(add|sub)' contract='-ffp-contract=fast -mfma' ;;
  aarch64) disassembler=aarch64-linux-gnu-objdump fused='[[:space:]](fn?m(add|sub)|fml[as]l?2?|fcmla)[[:space:]]' ;;
  armhf) disassembler=arm-linux-gnueabihf-objdump fused='[[:space:]]vfn?m[as]\.' contract='-ffp-contract=fast -mfpu=vfpv4' ;;
  riscv64) disassembler=riscv64-linux-gnu-objdump fused='[[:space:]]fn?m(add|sub)\.[sdq]' ;;
  s390x) disassembler=s390x-linux-gnu-objdump fused='[[:space:]]([mn]?m[as][edx]br?|[vw]fn?m[as][sdx]?b?)[[:space:]]' ;;
  ppc64le)
    disassembler=powerpc64le-linux-gnu-objdump
    fused='[[:space:]](fn?m(add|sub)s?\.?|x[sv]n?m(add|sub)[am][ds]p|vn?m(add|sub)fp)[[:space:]]'
    ;;
  *) disassembler=llvm-objdump-14 fused='relaxed_n?madd' contract= ;;
esac
count_fused() { "$disassembler" -d "$@" 2>/dev/null | grep -cE "$fused"; }

check_fused() {
  fused_count='-'
  command -v "$disassembler" >/dev/null 2>&1 || { printf 'no %s: fused instructions not looked for\n' "$disassembler"; return; }
  program=$(sed -n 's/^set(CMAKE_CXX_COMPILER "\(.*\)")$/\1/p' "build/$name"/CMakeFiles/*/CMakeCXXCompiler.cmake | head -n 1)
  if [ -n "$contract" ]; then
    printf 'double f(double a, double b, double c) { return a * b + c; }\n' >"$out/contract.cpp"
    # shellcheck disable=SC2086 # flags are words
    "$program" -O2 $contract -c "$out/contract.cpp" -o "$out/contract.o" && [ "$(count_fused "$out/contract.o")" -gt 0 ] ||
      find_fault "fused: the pattern does not find a contracted product: found 0, expected 1"
  fi
  find "build/$name/engine" -name '*.o' -o -name '*.obj' >"$out/objects"
  # shellcheck disable=SC2046 # paths of the build have no blanks
  fused_count=$(count_fused $(cat "$out/objects"))
  [ -s "$out/objects" ] && [ "$fused_count" = 0 ] ||
    find_fault "fused: found $fused_count fused instructions in the engine's $(wc -l <"$out/objects") objects, expected 0"
}

# --- traces between platforms ----------------------------------------------------------------------------------------

# name, scene, inputs, ticks: recorded on every platform and compared with the reference. `overflow` ends when a value
# becomes infinite. `drift` goes through subnormal numbers.
travel_scenes='stack stack?boxes=4&precision=f32 - 120
pile mixed_pile?bodies=12&precision=f64 - 120
thesis thesis?precision=f32 traces/thesis_mouse.jsonl 180
overflow tests/platforms/overflow.json tests/platforms/overflow.jsonl 60
drift tests/platforms/drift.json - 120'

record_scene() {
  output=$out/$1.ttr
  scene=$2
  inputs=$3
  tick_count=$4
  if [ "$extent" = quick ]; then
    tool record "$scene" "$inputs" "$tick_count" "$output" >"$output.json" 2>"$output.log"
    return
  fi
  set -- --ticks "$tick_count" --detail full:90..110 --checkpoint-interval 30 --no-compress --force --json -o "$output"
  [ "$inputs" = - ] || set -- "$@" --inputs "$inputs"
  tool record "$scene" "$@" >"$output.json" 2>"$output.log"
}

check_travel() {
  travel=0
  printf '%s\n' "$travel_scenes" >"$out/scenes"
  while read -r label scene inputs tick_count; do
    expected=0
    [ "$label" != overflow ] || expected=1
    record_scene "$label" "$scene" "$inputs" "$tick_count" </dev/null
    code=$?
    if [ "$code" != "$expected" ]; then
      find_fault "record $label: exit code: found $code, expected $expected: $(head -n 1 "$out/$label.ttr.log")"
      continue
    fi
    note=$(grep '"note"' "$out/$label.ttr.json" | tr -d '\r')
    expected=$(grep '"note"' "out/platforms/$reference/$label.ttr.json")
    [ "$note" = "$expected" ] || find_fault "record $label: finding: found $note, expected $expected"
    # Verifies the reference's trace here, and this platform's trace there. Also compares both by content, without build
    # facts.
    tool verify "out/platforms/$reference/$label.ttr" </dev/null >"$out/$label.here" 2>&1 ||
      find_fault "verify here, recorded by $reference: $(head -n 1 "$out/$label.here")"
    "build/$reference/run" "$program" verify "$out/$label.ttr" </dev/null >"$out/$label.there" 2>&1 ||
      find_fault "verify by $reference, recorded here: $(head -n 1 "$out/$label.there")"
    "build/$reference/run" "$program" diff "out/platforms/$reference/$label.ttr" "$out/$label.ttr" </dev/null >"$out/$label.diff" 2>&1 ||
      find_fault "diff $label: $(head -n 1 "$out/$label.diff")"
    travel=$((travel + 1))
  done <"$out/scenes"
}

# --- messages -------------------------------------------------------------------------------------------------------

# Output to a file gets no progress bar, whatever the platform's isatty returns.
check_no_bar() {
  if [ "$extent" = quick ]; then
    tool bar </dev/null >"$out/bar.out" 2>"$out/bar.err" || find_fault "progress: $(head -n 1 "$out/bar.err")"
  else
    scene=stack
    [ "$name" != wasm ] || scene='mixed_pile?bodies=300' # node does not pass the environment: a run of seconds
    TICKTRUE_PROGRESS=at_once tool run "$scene" --ticks 600 </dev/null >"$out/bar.out" 2>"$out/bar.err"
  fi
  if grep -q "$(printf '\033')" "$out/bar.err"; then find_fault "progress: found a bar in a file, expected none"; fi
}

# The result only counts for the record if the sources did not change meanwhile.
digest=$(sh tests/platforms/record.sh digest)

# --- all steps ------------------------------------------------------------------------------------------------------

traces=- ticks=- worlds=- compiler=- target=- tests=- travel=- fused_count=- probe=- build_user=- build_wall=- run_user=- run_wall=-

# An object whose source changed while it was compiled has the old code and is newer than the source. So a build that was
# cut off, or during which sources changed, leaves this file, and the next one compiles everything anew.
unfinished=build/$name/unfinished

build_all() {
  set -- trace_check portable_tests platform_check
  [ "$extent" = quick ] || set -- "$@" ticktrue
  [ ! -e "$unfinished" ] || set -- "$@" --clean-first
  touch "$unfinished"
  cmake --build "build/$name" -j "$jobs" --target "$@" || return
  changed=$(find base engine replay tests/platforms tests/portable -name '*.h' -newer "$unfinished" -o -name '*.cpp' -newer "$unfinished")
  if [ -n "$changed" ]; then
    find_fault "sources changed during the build: $(printf '%s' "$changed" | head -n 1)"
  else
    rm "$unfinished"
  fi
}

main() {
  start_phase
  cmake --preset "$name" || { find_fault "configuration failed"; return; }
  if ! build_all; then
    # Names that only collide in a unity build are no difference of the platform.
    echo "built again, file by file"
    cmake --preset "$name" -DTICKTRUE_UNITY=OFF && build_all || { find_fault "build failed"; return; }
  fi
  end_phase
  build_user=$user build_wall=$wall

  start_phase
  run trace_check traces/*.ttr >"$out/traces" 2>&1
  code=$?
  cat "$out/traces"
  traces=$(sed -n 's/.*: \([0-9]*\) traces, [0-9]* ticks.*/\1/p' "$out/traces")
  ticks=$(sed -n 's/.* traces, \([0-9]*\) ticks.*/\1/p' "$out/traces")
  [ "$code" = 0 ] || find_fault "$(grep error "$out/traces" | head -n 1)"
  run platform_check worlds tests/worlds/hashes.tsv >"$out/worlds" 2>&1 || find_fault "worlds: $(grep -m 1 error "$out/worlds")"
  cat "$out/worlds"
  worlds=$(sed -n 's/^\([0-9]*\) worlds, .*/\1/p' "$out/worlds")
  [ "${worlds:-0}" -ge 100 ] || find_fault "worlds: found ${worlds:-0}, expected at least 100"
  tests=passed
  # The worlds are compared above. The distance between the engine's sine and the C library's is not checked if that
  # library is inexact (MinGW).
  run portable_tests '~[trig]~"random worlds have*",[golden]' >"$out/tests" 2>&1 || { tests=FAILED; find_fault "portable tests: $(grep -m 1 "FAILED:" "$out/tests"; tail -n 3 "$out/tests" | tr "\n" " ")"; }
  tail -n 3 "$out/tests"
  if [ "$extent" = quick ]; then set -- env; else set -- env --check --json; fi
  tool "$@" >"$out/env.json" || find_fault "env --check: another digest than every platform must give"
  compiler=$(json_value compiler "$out/env.json")
  target=$(json_value target "$out/env.json")
  probe=$(sed -n 's/.*"digest": "\(.*\)",/\1/p' "$out/env.json" | tail -n 1 | tr -d '\r')
  check_travel
  check_no_bar
  check_fused
  end_phase
  run_user=$user run_wall=$wall
}

main >"$out/log" 2>&1
[ "$(sh tests/platforms/record.sh digest)" = "$digest" ] || digest=
ok=true
[ -z "$first" ] || ok=false
printf '%s\n' "$name$tab$compiler$tab$target$tab$traces$tab$ticks$tab$worlds$tab$tests$tab$travel$tab$fused_count$tab$build_user$tab$build_wall$tab$run_user$tab$run_wall$tab${first:-none}" \
  >"$out/row.tsv"
number() { case $1 in -|'') printf null ;; *) printf '%s' "$1" ;; esac; }
cat >"$out/result.json" <<JSON
    {
      "platform": "$name", "ok": $ok, "compiler": "$(json_text "$compiler")", "target": "$(json_text "$target")",
      "traces": $(number "$traces"), "ticks": $(number "$ticks"), "worlds": $(number "$worlds"), "portable_tests": "$tests",
      "travelled": $(number "$travel"), "fused_instructions": $(number "$fused_count"), "probe": "$probe",
      "engine_digest": "$digest",
      "build_user_s": $(number "$build_user"), "build_wall_s": $(number "$build_wall"),
      "run_user_s": $(number "$run_user"), "run_wall_s": $(number "$run_wall"),
      "first_difference": $([ -n "$first" ] && printf '"%s"' "$(json_text "$first")" || printf null)
    }
JSON
if [ "$ok" = true ]; then
  echo "$name: same bits: $traces traces, $ticks ticks, $worlds worlds, $travel carried to and fro; build $build_wall s, run $run_wall s"
else
  echo "$name: DIFFERS: $first"
fi
[ "$ok" = true ]
