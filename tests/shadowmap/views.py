"""Views and lights to fit shadow maps to."""

import numpy as np
from hypothesis import strategies as st

from archsim.scene.camera import Camera
from archsim.shadowmap.view import directional_light, make_view, point_light

ALONG_Y = Camera(np.zeros(3), np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 60.0, 1.0)


def view_of(ratio, aspect=1.0):
    return make_view(ALONG_Y, aspect, float(ratio))


OVERHEAD = directional_light(np.array([0.0, 0.0, 1.0]))
NUMBERS = st.floats(-1, 1)
DIRECTIONS = (
    st.tuples(NUMBERS, NUMBERS, NUMBERS)
    .filter(lambda d: min(abs(v) for v in d) > 0.05)
    .map(lambda d: directional_light(np.array(d)))
)
POINTS_INSIDE = st.tuples(NUMBERS, NUMBERS, st.floats(0.2, 0.8)).map(
    lambda p: point_light(np.array([0.4 * p[0] * 20 * p[2], 20 * p[2], 0.4 * p[1] * 20 * p[2]]))
)
