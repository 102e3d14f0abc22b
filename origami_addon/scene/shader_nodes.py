"""The shader nodes of materials and worlds."""

from __future__ import annotations

import bpy


def without_nodes(owner: bpy.types.Material | bpy.types.World) -> tuple[bpy.types.Nodes, bpy.types.NodeLinks]:
    """The nodes and links of a new material or world, emptied of those that Blender puts there."""
    if owner.node_tree is None:
        owner.use_nodes = True  # always so, and deprecated, from Blender 5.0 on
    nodes, links = owner.node_tree.nodes, owner.node_tree.links
    nodes.clear()
    return nodes, links
