"""The order in which volumes are submitted: it moves whole volumes, and no pixel."""

import numpy as np
import pytest

from archsim.shadow_volumes.casters import Grouping
from archsim.shadow_volumes.comparison import HIERARCHICAL, draw
from archsim.shadow_volumes.order import Order, picked, ranks
from tests.shadow.scenes import soup
from tests.shadow_volumes.scenes import RESOURCES, method, prepared

BOX = np.array(
    [[[0, 0, 0], [1, 1, 1]], [[9, 0, 0], [9, 1, 1]], [[4, 0, 0], [6, 2, 2]], [[0, 0, 0], [1, 1, 1]]], float
)


@pytest.mark.parametrize(
    ("order", "chosen"),
    [
        (Order.SCENE, [0, 1, 2, 3]),
        (Order.REVERSE, [3, 2, 1, 0]),
        (Order.NEAR_LIGHT, [1, 2, 0, 3]),
        (Order.LARGE, [2, 0, 3, 1]),
    ],
)
def test_orders(order, chosen):
    assert ranks(order, BOX, np.array([10.0, 0, 0])).tolist() == chosen


def test_groups_move_as_a_whole():
    rows, starts = picked(np.array([0, 2, 2, 5]), np.array([2, 0, 1]))
    assert rows.tolist() == [2, 3, 4, 0, 1]
    assert starts.tolist() == [0, 3, 5, 5]


@pytest.mark.parametrize("order", Order)
def test_the_mask_is_the_same_in_every_order(order):
    scene, choice = soup(3, 25), method(grouping=Grouping.TRIANGLES)
    ordered = choice._replace(extrusion=choice.extrusion._replace(order=order))
    views = [prepared(scene, each) for each in (choice, ordered)]
    masks = [draw(view, HIERARCHICAL, RESOURCES).shadow for view in views]
    np.testing.assert_array_equal(*masks)
    assert len({len(view.seen.volumes.triangles) for view in views}) == 1
