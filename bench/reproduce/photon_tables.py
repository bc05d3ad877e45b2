"""Tables 8.7 to 8.9 of the thesis on hybrid sampling: photon mapping.

The rows are written as the thesis prints them, one per line; '-' is an empty cell:
  N method seconds camera-samples photons caustic-photons gather-samples distance
  area-of-A[%] lights IS MPA
All pre-sampled maps have 360 samples, and all lights of hybrid rows are clustered by F2; N under
gather-samples means no final gathering. The thesis gives times and no errors: the method is biased,
so it compares pictures.
"""

from tables import (Recipe, Row, Table, as_printed, compensated, hybrid_strategy,
                    light_parameters, method_name)

PRESAMPLED = 360

SPONZA_1 = """
1 IS 525.9 4 100000 0 64 1.5 0 - 64 -
2 HIB 462.8 4 100000 0 64 1.5 0.864 OS:64 - 32
3 IS 702.5 4 100000 0 64 1.5 0 - 128 -
4 HIB 530.9 4 100000 0 64 1.5 0.864 OS:64 - 64
5 IS 1379.4 8 100000 0 64 1.5 0 - 128 -
6 HIB 1080.6 8 100000 0 64 1.5 0.864 OS:64 - 64
7 IS 2129.6 8 100000 0 64 1.5 0 - 256 -
8 DL 1016.0 8 100000 0 64 1.5 100 MC:256 - -
9 DL 854.5 4 200000 0 64 2.5 100 MC:256 - -
10 HIB 906.9 4 200000 0 64 2.5 0.864 OS:64 - 64
"""

SPONZA_2 = """
1 HIB 137.8 4 100000 0 N 1.5 0.864 OS:64 - 32
2 HIB 823.4 4 100000 0 64 1.5 0.864 OS:64 - 32
3 IS 197.3 4 100000 0 N 1.5 0 - 64 -
4 IS 946.6 4 100000 0 64 1.5 0 - 64 -
5 DL 173.3 4 100000 0 N 1.5 100 MC:256 - -
6 DL 889.7 4 100000 0 64 1.5 100 MC:256 - -
7 IS 380.9 4 100000 0 N 1.5 0 - 128 -
8 IS 1142.5 4 100000 0 64 1.5 0 - 128 -
9 HIB 89.3 4 100000 0 N 1.5 0.864 OS:64 - 16
10 HIB 782.6 4 100000 0 64 1.5 0.864 OS:64 - 16
11 HIB 199.8 4 100000 0 N 1.5 0.864 OS:64 - 64
12 HIB 910.1 4 100000 0 64 1.5 0.864 OS:64 - 64
"""

THREE_SPHERES = """
1 HIB 768.7 4 100000 100000 100 50 0.864 OS:64 - 32
2 HIB 794.8 4 100000 100000 100 50 0.864 OS:64 - 64
3 IS 853.4 4 100000 100000 100 50 0 - 128 -
4 DL 735.3 4 100000 100000 100 50 100 MC:256 - -
5 HIB 673.6 4 100000 20000 100 50 0.864 OS:64 - 64
6 IS 801.6 4 100000 20000 100 50 0 - 128 -
7 DL 680.5 4 100000 20000 100 50 100 MC:256 - -
8 DL 445.6 4 100000 20000 100 5 100 MC:256 - -
9 HIB 435.5 4 100000 20000 100 5 0.864 OS:64 - 64
10 IS 571.6 4 100000 20000 100 5 0 - 128 -
"""


def read_photon_row(line, unit):
    """Reads a row; `unit` is the length in Skywave's scene of one unit in the thesis's."""
    name, method, seconds, samples, photons, caustic, gather, distance, area, lights, importance, \
        mpa = line.split()
    gathered = 0 if gather == "N" else int(gather)
    row = Row(name, method_name(method), "", None, seconds=float(seconds))
    clustering = "F2" if method == "HIB" else "-"
    row.parameters = ", ".join(
        [f"AA {samples}", f"{photons} + {caustic} photons", f"RF {gather}", f"DM {distance}",
         as_printed(area, clustering, lights, importance,
                    "-" if mpa == "-" else f"OS({PRESAMPLED}):{mpa}")])
    row.lights = 0 if lights == "-" else int(lights.split(":")[1])
    row.drawn = int(mpa if mpa != "-" else importance if importance != "-" else 0)
    row.presampled = mpa != "-"
    if method == "IS":
        strategy = "importance"
    elif method == "DL":
        source, _, parameters = light_parameters(lights, clustering)
        strategy = f"{source}:" + ",".join(parameters)
    else:
        strategy = hybrid_strategy(float(area), clustering, lights, PRESAMPLED)
    flags = ["--photons", photons, "--caustic-photons", caustic,
             "--gather", gathered, "--photon-distance", f"{float(distance) * unit:g}"]
    row.recipe = Recipe(strategy, int(samples), max(row.drawn, 1), flags=flags)
    return row


def read(text, unit=1.0):
    return [read_photon_row(line, unit) for line in text.strip().splitlines()]


PHOTON = {"integrator": "photon", "reference": (32768, 1), "quick_reference": (512, 1),
          "reference_strategy": compensated(1)}

PHOTON_TABLES = {table.name: table for table in [
    Table("8.7", "Photon mapping, Sponza 1 (the courtyard) under Galileo", "sponza", "galileo",
          base="7", pairs=[("2", "1"), ("4", "3"), ("6", "5"), ("8", "7"), ("10", "9")],
          camera=["--eye=-12,2,0", "--target", "10,4,0", "--fov", 60], **PHOTON,
          rows=read(SPONZA_1)),
    Table("8.8", "Photon mapping, Sponza 2 (the arcade) under Galileo", "sponza", "galileo",
          base="8", pairs=[("2", "4"), ("12", "8"), ("1", "3"), ("11", "7"), ("9", "3")],
          camera=["--eye=-12,1.8,-5.2", "--target", "10,2.5,-3", "--fov", 60], **PHOTON,
          rows=read(SPONZA_2)),
    Table("8.9", "Photon mapping, three spheres under Galileo", "three-spheres", "galileo",
          base="3", pairs=[("2", "3"), ("5", "6"), ("9", "10"), ("8", "10")], **PHOTON,
          rows=read(THREE_SPHERES, 0.02)),
]}
