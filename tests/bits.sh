#!/usr/bin/env bash
# Prints a hash of every channel of some small images, each of which names its method, and of what their reports
# count. A change that is not meant to change numbers leaves the list as it was:
#   bash tests/bits.sh [program] > before; ...; bash tests/bits.sh [program] | diff before -
# Needs python3.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=$(realpath "${1:-$root/build/obscura}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

python3 - <<'PYTHON'
# Writes the scenes: what each has beside the common ones' parts.
import json

def scene(name, **parts):
    base = {"obscura": 1, "name": name, "bands": [{"name": "vis"}],
            "sensor": {"position_m": [0, -14, 3], "look_at_m": [0, 0, 0.2], "fov_deg": 24, "resolution": [40, 30], "max_oversampling": 8}}
    base.update(parts)
    json.dump(base, open(name + ".json", "w"))

def view(**parts):
    return dict({"position_m": [0, -14, 3], "look_at_m": [0, 0, 0.2], "fov_deg": 24, "resolution": [40, 30], "max_oversampling": 8}, **parts)

uniform = {"polygons": 0}
hg = {"type": "henyey_greenstein", "g": 0.6}
puff = {"grid": {"shape": "gaussian", "sigma_m": 0.8, "size_m": [5, 5, 5], "voxel_m": 0.25}, "media": [{"extinction": 2, "albedo": 0.9, "phase": hg}]}
day = {"sky": {"radiance": 0.1}, "sun": {"zenith_deg": 40, "azimuth_deg": 150, "irradiance": 1}}
photon = {"method": "photon", "final_gather": 0, "photons": 40000, "nearest": 24}
gather = {"method": "photon", "final_gather": 1, "photons": 40000, "nearest": 24, "samples": 16}
path = {"method": "path", "samples": 16}
places = {"probes": [{"name": "p", "position_m": [0.1, 0.2, 0.3]}], "flux": [{"name": "f", "center_m": [0, 0, -2.7], "normal": [0, 0, -1], "size_m": [6, 6]}]}
for way, render in {"photon": photon, "gather": gather, "path": path}.items():
    scene("sunlit_" + way, clouds=[puff], environment=day, render=render, **places)

# Infrared, two overlapping clouds, two bands with intervals, air, every phase function.
bands = [{"name": "lwir", "um": [8, 12], "samples": 2, "response": {"um": [8, 10, 12], "value": [0.2, 1, 0.2]}}, {"name": "mwir", "um": [3, 5]}]
table = {"type": "table", "angle_deg": [0, 30, 90, 180], "value": [0.5, 0.2, 0.05, 0.03]}
warm = [{"grid": {"shape": "sphere", "radius_m": 1.2, "voxel_m": 0.15}, "media": [{"extinction": {"um": [3, 12], "value": [2, 1]}, "albedo": 0.5, "phase": table}, {"extinction": 0.2, "albedo": 0.9, "phase": {"type": "rayleigh"}}], "temperature": {"K": 320}},
        {"grid": {"shape": "box", "size_m": [2, 2, 2], "voxel_m": 0.25}, "media": [{"extinction": 0.7, "albedo": 0.4, "phase": {"type": "double_henyey_greenstein", "g1": 0.8, "g2": -0.3, "weight": 0.8}}], "temperature": {"K": 290}, "place": {"translate_m": [0.8, 0.5, 0.3], "rotate_deg": [10, 20, 30]}}]
night = {"sky": {"K": 250}, "atmosphere": {"extinction_per_m": 1e-3, "K": 285}}
for way, render in {"photon": photon, "gather": gather, "path": path}.items():
    scene("warm_" + way, bands=bands, clouds=warm, environment=night, render=render)

# Surfaces, mirrors sharp and rough, a net, a flare, particles, a detector.
materials = {"ground": {"emissivity": 0.7}, "mirror": {"emissivity": 0.1, "specular": 1}, "rough": {"emissivity": 0.3, "specular": 0.6, "roughness": 0.2}, "net": {"emissivity": 0.9, "permeable": 0.5}}
objects = [{"shape": "plane", "size_m": [30, 30], "material": "ground", "K": 290, "place": {"translate_m": [0, 0, -1.5]}},
           {"shape": "box", "size_m": [1, 1, 1.5], "material": "mirror", "K": 300, "place": {"translate_m": [-2, 0, -0.7], "rotate_deg": [0, 0, 30]}},
           {"shape": "sphere", "radius_m": 0.7, "material": "rough", "K": 330, "place": {"translate_m": [2, 0.5, -0.6]}},
           {"shape": "plane", "size_m": [1.5, 1.5], "material": "net", "K": 280, "double_sided": True, "place": {"translate_m": [0.5, -2, 0], "rotate_deg": [90, 0, 0]}}]
flare = [{"name": "flare", "position_m": [0.5, 0, 1.4], "radius_m": 0.1, "K": 900}]
detector = {"psf_sigma_px": 0.7, "nedt_K": 0.05, "bits": 12, "range": [0, 80], "dead_share": 0.01}
smoke = [dict(puff, media=[{"extinction": 0.8, "albedo": 0.6, "phase": hg}], temperature={"K": 310})]
for way, render in {"photon": photon, "gather": gather, "path": path}.items():
    scene("surfaces_" + way, bands=[bands[0]], clouds=smoke, objects=objects, materials=materials, sources=flare, environment={"sky": {"K": 250}}, sensor=view(detector=detector), render=render, **places)

# Adaptive, uniform and error-driven rays; rays that see cells as a whole; particles; beams; periods; passes.
open("p.csv", "w").write("s,x_m,y_m,z_m,radius_m,K\n0,0,0,1,0.05,900\n1,0.5,0,1.5,0.05,800\n")
scene("uniform", clouds=[puff], environment=day, sensor=view(antialiasing=uniform, max_oversampling=4), render=path)
scene("by_error", clouds=[puff], environment=day, sensor=view(antialiasing={"error": 0.02}), render=gather)
fine = {"grid": {"shape": "gaussian", "sigma_m": 0.8, "size_m": [5, 5, 5], "voxel_m": 0.04}, "media": [{"extinction": 1}], "temperature": {"grid": "density", "scale": 40, "offset_K": 280}}
scene("footprint", bands=[bands[1]], clouds=[fine], sensor=view(resolution=[24, 18]), render=dict(photon, octree_tolerance=0.01))
scene("particles", bands=[bands[1]], clouds=smoke, particles={"file": "p.csv"}, render=path)
scene("beams", clouds=[puff], beams=[{"position_m": [0, 0, 5], "toward": [0, 0, -1], "radius_m": 0, "power": 1}], render=photon, **places)
slab = {"grid": {"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.125}, "media": [{"extinction": 3, "albedo": 0.9, "phase": hg}], "periodic": ["x", "y"], "period_m": [1, 1]}
scene("periodic_photon", clouds=[slab], environment=day, render=photon)
scene("periodic_path", clouds=[slab], environment=day, render=path)
scene("passes", clouds=[puff], environment=day, sensor=view(resolution=[4, 3], max_oversampling=2), render={"method": "path", "samples": 5000})
scene("limited", clouds=[puff], environment=day, sensor=view(scattering_depth=2, projection="fisheye", fov_deg=60), render=photon)
PYTHON
cp "$root"/scene/examples/smoke_at_night.json "$root"/scene/examples/hills.asc .

# Hashes of the image's channels, and of each part of its report that does not depend on time or machine.
hash_results() {
  python3 - "$1" <<'PYTHON'
import hashlib, itertools, json, struct, sys, zlib

def channels(file):
    """The pixels of each channel of an OpenEXR file as the program writes it: scanlines, float, ZIP."""
    data = open(file, "rb").read()
    at, header = 8, {}
    while data[at]:
        name, kind = (data[at:].split(b"\0", 2)[i].decode() for i in (0, 1))
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        header[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    names, left = [], header["channels"]
    while left[0]:
        name, rest = left.split(b"\0", 1)
        assert struct.unpack_from("<i", rest)[0] == 2, "a channel that is not float"
        names.append(name.decode())
        left = rest[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    lines = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    row = 4 * (x1 - x0 + 1)
    pixels = {name: b"" for name in names}
    for offset in struct.unpack_from("<%dQ" % -(-(y1 - y0 + 1) // lines), data, at + 1):
        y, size = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8:offset + 8 + size]
        count = min(lines, y1 + 1 - y)
        if size < count * row * len(names):
            raw = list(zlib.decompress(block))
            raw = bytes(itertools.accumulate(raw, lambda a, b: (a + b - 128) & 255))
            half = (len(raw) + 1) // 2
            block = bytes(itertools.chain.from_iterable(zip(raw[:half], raw[half:])))
        for line in range(count):
            for c, name in enumerate(names):
                begin = (line * len(names) + c) * row
                pixels[name] += block[begin:begin + row]
    return pixels

name = sys.argv[1]
for channel, pixels in channels(name + ".exr").items():
    print(name, channel, hashlib.sha1(pixels).hexdigest())
report = json.load(open(name + ".report.json"))
for row in report.get("plan", []):
    row.pop("cost_s", None)
for key, value in report.items():
    if key not in ("time_s", "memory", "method", "version", "hash", "accuracy", "warnings"):
        print(name, "report." + key, hashlib.sha1(json.dumps(value, sort_keys=True).encode()).hexdigest())
PYTHON
}

render() {
  local name=$1 scene=$2
  shift 2
  "$program" render "$scene" -o "$name.exr" --report "$name.report.json" --quiet "$@" 2> "$name.err" || { echo "$name failed" >&2; cat "$name.err" >&2; exit 1; }
  hash_results "$name"
}

for file in $(ls ./*.json | grep -v smoke_at_night); do render "$(basename "$file" .json)" "$file"; done
for method in photon path; do
  render "demo_$method" smoke_at_night.json --method $method --photons 100000 --samples 8 --set '/sensor/resolution=[64,28]' --set /clouds/0/puffs/voxel_m=0.5
done
"$program" obscuration surfaces_gather.json --object object3 --csv hidden.csv --quiet > /dev/null 2>&1 || "$program" obscuration surfaces_gather.json --csv hidden.csv --quiet
echo "obscuration csv $(sha1sum < hidden.csv | cut -d' ' -f1)"
