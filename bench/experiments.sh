#!/bin/sh
# Runs the commands of docs/experiments.md and replaces their output, or compares it.
# SPDX-License-Identifier: MIT
#
# usage: experiments.sh run|check all|same|quick     with the tools on PATH
# A block begins with "```text", "```text same" or "```text quick" and a line "$ COMMAND". The output of `same` and
# `quick` blocks is the same on every machine; `quick` blocks take seconds. Commands run in docs/; raw data goes to
# out/experiments. check: exit code 1 if a block that should be the same differs, with the difference on stdout.
set -u
cd "$(dirname "$0")/.." || exit 2
action=${1-run}
which=${2-all}
case $action/$which in
  run/all | run/same | run/quick | check/same | check/quick) ;;
  *)
    echo "experiments.sh: error: found $action $which, expected run all|same|quick or check same|quick" >&2
    exit 2
    ;;
esac
page=docs/experiments.md
out=out/experiments
mkdir -p $out docs/experiments
: >$out/page

is_wanted() { # KIND
  case $which/$1 in
    all/* | same/same | same/quick | quick/quick) return 0 ;;
  esac
  return 1
}

block_count=0
differ_count=0
while IFS= read -r line; do
  printf '%s\n' "$line" >>$out/page
  case $line in
    '```text'*) ;;
    *) continue ;;
  esac
  kind=${line#'```text'}
  kind=${kind# }
  IFS= read -r command
  : >$out/old
  while IFS= read -r inner && [ "$inner" != '```' ]; do printf '%s\n' "$inner" >>$out/old; done
  case $command in
    '$ '*) ;;
    *)
      echo "experiments.sh: error: $page: found a block that begins with \"$command\", expected \$ and a command" >&2
      exit 2
      ;;
  esac
  new=$out/old
  if is_wanted "$kind"; then
    echo "$command" >&2
    block_count=$((block_count + 1))
    new=$out/new
    (cd docs && sh -c "${command#'$ '}") >$new 2>$out/messages </dev/null
    status=$?
    if [ $status -gt 1 ]; then # 1: a finding, which is part of what is shown
      echo "experiments.sh: error: exit code $status: $command" >&2
      cat $out/messages >&2
      exit 2
    fi
    if [ "$action" = check ] && ! diff $out/old $new >$out/difference; then
      differ_count=$((differ_count + 1))
      printf '%s\n' "$command"
      cat $out/difference
    fi
  fi
  {
    printf '%s\n' "$command"
    cat $new
    printf '%s\n' '```'
  } >>$out/page
done <$page
[ "$action" = check ] || cp $out/page $page
echo "$block_count commands, $differ_count differ" >&2
[ $block_count -gt 0 ] && [ $differ_count = 0 ]
