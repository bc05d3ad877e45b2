"""The textures of the truth test, by the formulas and numbers of those that pbrt saw."""

import math

from pictures import write_pfm, write_png

SIDE = 256

# 24 x 16 squares of 8 x 8 pixels: noise, a bright patch and a frame at two sides, so that an image
# that is turned, mirrored or moved by a square is another one.
SQUARES = """
10 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250 250
10 211 80 149 199 110 89 124 130 117 177 126 172 82 27 191 53 143 99 196 57 40 114 69
10 147 255 255 139 74 20 212 38 136 211 185 204 204 219 185 194 53 133 21 105 137 139 222
10 119 255 255 180 164 38 95 203 116 161 185 178 68 209 53 72 22 176 56 110 192 196 79
10 202 255 255 133 76 124 59 49 180 196 29 53 208 75 31 232 158 132 228 96 88 64 64
10 164 255 255 198 213 55 193 72 21 38 211 22 168 82 229 42 155 205 191 52 112 80 164
10 73 127 28 40 28 172 226 96 39 120 157 46 198 80 153 232 115 126 101 29 52 161 64
10 112 56 145 190 220 46 172 168 82 192 178 165 136 52 201 106 59 80 115 52 108 181 144
10 71 110 227 112 31 37 199 91 33 115 216 83 61 33 225 116 80 195 184 203 204 233 218
10 32 176 131 130 158 159 55 233 69 92 54 31 109 207 152 105 20 204 114 193 219 117 169
10 49 190 27 178 96 223 187 77 197 128 192 41 114 61 219 54 163 42 65 56 188 110 72
10 167 89 202 160 46 183 172 200 63 139 171 198 38 84 219 201 180 98 142 231 46 23 185
10 130 142 171 96 38 54 112 26 218 167 80 225 138 129 59 84 80 160 188 141 24 62 145
10 169 20 55 97 41 88 113 89 145 133 189 218 65 180 85 219 215 45 135 46 226 170 96
10 50 99 151 90 66 67 162 95 25 234 227 139 228 208 182 213 58 70 207 38 49 211 41
10 160 43 37 178 56 27 94 45 119 133 158 199 21 104 130 73 142 102 160 216 133 23 210
"""


def _squares():
    return [[int(value) for value in line.split() for _ in range(8)]
            for line in SQUARES.strip().split("\n") for _ in range(8)]


def _normal(x, y):
    slope_x = -0.35 * math.sin(4 * math.pi * x)
    slope_y = -0.1 - 0.5 * math.sin(6 * math.pi * y)
    length = math.sqrt(slope_x * slope_x + slope_y * slope_y + 1)
    return tuple(int((c / length * 0.5 + 0.5) * 255 + 0.5) for c in (slope_x, slope_y, 1))


def _height(x, y):
    return (0.5 + 1.2 * y * x * (1 - x) +
            0.5 * math.sin(6 * math.pi * x) * math.cos(4 * math.pi * y))


def _mask(x, y):
    """Discs in 8 x 8 cells, and a quarter of the first quadrant that is 0.4."""
    if x < 0.25 and y < 0.25:
        return 0.4
    u, v = x * 8 % 1 - 0.5, y * 8 % 1 - 0.5
    return 1.0 if u * u + v * v < 0.35 * 0.35 else 0.0


def _sampled(function):
    """Returns the rows, from the top, of a function of x to the right and y downwards."""
    at = [(i + 0.5) / SIDE for i in range(SIDE)]
    return [[function(x, y) for x in at] for y in at]


def _turned(squares):
    """The squares, and as green and blue the same mirrored and upside down."""
    return [[(v, mirrored, turned) for v, mirrored, turned in zip(row, row[::-1], last)]
            for row, last in zip(squares, squares[::-1])]


def _coarse():
    """8 x 8 colours of 16 bits, those of squares that touch."""
    values = [[int(v) for v in line.split()] for line in SQUARES.strip().split("\n")]
    return [[tuple(257 * values[y + 4 * c][x + 2] for c in range(3)) for x in range(8)]
            for y in range(8)]


def write_textures(folder):
    squares = _squares()
    write_png(folder / "colours.png", _turned(squares))
    write_png(folder / "alpha.png", [[(255, v, 0, v) for v in row] for row in squares])
    write_png(folder / "coarse16.png", _coarse(), bits=16)
    write_png(folder / "squares.png", [[(v, v, v) for v in row] for row in squares])
    write_png(folder / "squares1.png", squares)
    write_png(folder / "normal.png", _sampled(_normal))
    write_pfm(folder / "height.pfm", _sampled(_height))
    write_pfm(folder / "mask.pfm", _sampled(_mask))
