"""What was saved stays as it was, whatever is done to the nodes afterwards."""

import copy

import numpy as np

from trackweave.association.node_room import NodeRoom


class Room(NodeRoom):
    """A room that can be filled and thinned by name."""

    def fill(self, count):
        self._reserve(count)
        span = slice(self.n_nodes, self.n_nodes + count)
        for column in self.nodes:
            column[span] = 0
        self.nodes.parent[span] = -1
        self.nodes.cost[span] = np.arange(count)
        self.n_nodes += count

    def thin(self, kept):
        self._compact(np.isin(self.costs(), kept))

    def own(self):
        self._own()

    def costs(self):
        return self.nodes.cost[: self.n_nodes].copy()


def filled():
    room = Room(1, 4)
    room.fill(6)
    return room


def test_what_was_saved_outlives_thinning_changing_and_filling():
    room = filled()
    old = room.saved()
    room.thin([1, 3, 5])
    room.nodes.cost[:3] += 100.0
    room.fill(400)
    assert old.costs().tolist() == [0, 1, 2, 3, 4, 5]
    assert room.costs()[:3].tolist() == [101, 103, 105]


def test_changing_in_place_takes_a_room_of_its_own_first():
    room = filled()
    old = room.saved()
    room.own()
    room.nodes.cost[:] = -1.0
    assert old.costs().tolist() == [0, 1, 2, 3, 4, 5]


def test_two_rooms_serve_for_ever():
    room, rooms = filled(), set()
    for _ in range(6):
        old = room.saved()
        room.thin(np.arange(6))
        room.settled(old)
        rooms.add(id(room.nodes.parent))
    assert len(rooms) == 2


def test_without_anything_saved_nodes_stay_where_they_are():
    room = filled()
    before = room.nodes
    room.thin([0, 2])
    room.own()
    assert room.nodes is before
    assert room.costs().tolist() == [0, 2]


def test_a_copy_brings_no_spare_room_along():
    room = filled()
    old = room.saved()
    room.thin([0, 1])
    room.settled(old)
    assert copy.deepcopy(room)._spare is None
    assert room._spare is old.nodes
