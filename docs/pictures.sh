#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the documentation's pictures of episodes, from anywhere. With a folder, it also makes a page of each example
# there. HYPGEN names the command (default: hypgen). Searches are limited by trials, so that the pictures are the same
# on every machine.
set -euo pipefail
pages=${1:+$(realpath "$1")}
cd "$(dirname "$0")/.."

view() {
  local model=examples/$1.pomdp
  shift
  ${HYPGEN:-hypgen} view "$model" --mode despot --seed 7 "$@"
}

mkdir -p docs/guide/pictures
view rock_sample --trials 20 --gif docs/rock_sample.gif
for name in crowd_driving laser_tag light_dark navigation pocman tag; do
  view "$name" --trials 10 --scenarios 50 --steps 12 --gif "docs/guide/pictures/$name.gif"
done
if [ -n "$pages" ]; then
  for model in examples/*.pomdp; do
    name=$(basename "$model" .pomdp)
    case $name in # a decision of two robots takes long
      two_robot_rock_sample) few=(--trials 4 --steps 4) ;;
      *) few=(--trials 10 --steps 12) ;;
    esac
    view "$name" --scenarios 50 "${few[@]}" -o "$pages/$name.html"
  done
fi
