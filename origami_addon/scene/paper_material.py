"""The material of the sheet: matt paper with a picture on it."""

from __future__ import annotations

import bpy

from .shader_nodes import without_nodes


def paper_material(name: str, picture: bpy.types.Image, uv_layer: str) -> bpy.types.Material:
    """Matt paper with the picture mapped by a UV layer, built from nodes that exporters understand."""
    material = bpy.data.materials.new(name)
    nodes, links = without_nodes(material)
    output = nodes.new("ShaderNodeOutputMaterial")
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    surface.inputs["Roughness"].default_value = 1.0
    surface.inputs["Specular IOR Level"].default_value = 0.0
    texture = nodes.new("ShaderNodeTexImage")
    coordinates = nodes.new("ShaderNodeUVMap")
    texture.image = picture
    texture.extension = "EXTEND"
    coordinates.uv_map = uv_layer
    links.new(coordinates.outputs["UV"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    for place, node in enumerate((coordinates, texture, surface, output)):
        node.location = (300 * place, 0)
    return material
