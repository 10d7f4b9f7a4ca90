#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds an emitted project for a GPU and plays drives with its library. hypgen's compiler is not needed: Python,
# NumPy, CMake and nvcc are. More arguments go to vehicle.drives.
#
#   hypgen compile examples/vehicle/vehicle.pomdp --emit project --target cuda -o vehicle_project
#   examples/vehicle/on_gpu.sh vehicle_project drives.jsonl --rows despot,hyp --hertz 3,10
set -euo pipefail
project=$1 out=$2
shift 2
root=$(cd "$(dirname "$0")/../.." && pwd)
cmake -S "$project" -B "$project/build" -DCMAKE_BUILD_TYPE=Release -DHYPGEN_CUDA="${HYPGEN_CUDA:-ON}"
cmake --build "$project/build" --parallel "$(nproc)"
library=$(find "$(cd "$project" && pwd)/build" -name libvehicle.so | head -n 1)
PYTHONPATH="$root/src:$root/examples" "${PYTHON:-python3}" -m vehicle.drives \
  --library "$library" --out "$out" "$@"
