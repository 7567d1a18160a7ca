#!/bin/sh
# Draws the pictures of this folder anew: sh docs/make_pictures.sh, where phaseplane is installed.
set -e
cd "$(dirname "$0")"
phaseplane replay ap57 --figure ap57_phase_planes.png
phaseplane replay ap57_figure13 --figure ap57_figure13.png --kind figure13
phaseplane replay ap57_figure13 --figure ap57_figure4b.png --kind figure4b --step "7.5 ms"
phaseplane portrait van_der_pol --figure van_der_pol.png
python characteristics.py
python random_roads.py
# smaller files: 256 colours do
python - ap57_phase_planes.png ap57_figure13.png ap57_figure4b.png van_der_pol.png characteristics.png iso8608.png <<'END'
import sys
from PIL import Image
for name in sys.argv[1:]:
    Image.open(name).convert("RGB").quantize(256, kmeans=3).save(name, optimize=True)
END
