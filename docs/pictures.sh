#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the documentation's pictures of episodes, from anywhere; HYPGEN names the command (default: hypgen).
# Searches are limited by trials, so that the pictures are the same on every machine.
set -euo pipefail
cd "$(dirname "$0")/.."

${HYPGEN:-hypgen} view examples/rock_sample.pomdp --mode despot --trials 20 --seed 7 --gif docs/rock_sample.gif
