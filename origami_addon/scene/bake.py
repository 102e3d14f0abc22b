"""The Blender route from photo to page: a Cycles bake between the two UV layers of the sheet."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.errors import StepFailed
from ...core.page.photo_colors import Photo
from ..files.image_files import from_blender_image, to_blender_image, to_eight_bits
from .mesh_values import read_values
from .scratch_scene import alone
from .shader_nodes import without_nodes
from .sheet_mesh import PAGE_UV, PHOTO_DEPTH, PHOTO_UV

_HOMOGENEOUS = "origami_homogeneous"


def bake_page(sheet_object: bpy.types.Object, photo: Photo, size_px: tuple[int, int]) -> NDArray[np.uint8]:
    """Bake the page image from the photo of the UV layer `photo`.

    Sampling is linear. The mesh in Blender counts, with edits by hand.

    Parameters
    ----------
    sheet_object : bpy.types.Object
        With UV layers `page` and `photo`.
    photo : (h, w, 3) uint8 or uint16 array
        Baked in 8 bits.
    size_px : (width, height)
        Of the page image.

    Returns
    -------
    (height, width, 3) uint8 array
        White where the page has no triangle.

    Raises
    ------
    StepFailed
        If this Blender has no Cycles, or Cycles fails.
    """
    source = to_blender_image("origami bake source", to_eight_bits(photo))
    target = to_blender_image("origami bake target", np.full((size_px[1], size_px[0], 3), 255, np.uint8))
    material = _material(source, target)
    copy = sheet_object.copy()
    copy.data = sheet_object.data.copy()
    try:
        copy.data.materials.clear()
        copy.data.materials.append(material)
        _set_homogeneous(copy.data)
        copy.data.uv_layers.active = copy.data.uv_layers[PAGE_UV]
        with alone(copy) as scene:
            scene.render.engine = "CYCLES"
            scene.cycles.device = "CPU"
            scene.cycles.samples = 1  # one sample is the exact centre of the pixel
            scene.cycles.use_denoising = False
            bpy.ops.object.bake(type="EMIT", margin=0, use_clear=False, uv_layer=PAGE_UV)
        return from_blender_image(target)
    except (RuntimeError, TypeError) as error:  # TypeError: the engine does not exist
        raise StepFailed(f"Blender could not bake the page ({str(error).strip()}): use page.tif instead.") from error
    finally:
        mesh = copy.data
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        bpy.data.materials.remove(material)
        bpy.data.images.remove(source)
        bpy.data.images.remove(target)


def _set_homogeneous(mesh: bpy.types.Mesh) -> None:
    """Store at each corner its position in the photo times its depth, and the depth.

    These, unlike the positions themselves, change linearly over a triangle seen in perspective.
    """
    uv = read_values(mesh.uv_layers[PHOTO_UV].uv, "vector", 2, np.float32)
    depth = read_values(mesh.attributes[PHOTO_DEPTH].data, "value", 1, np.float32)
    at_corner = depth[read_values(mesh.loops, "vertex_index", 1, np.int32)] / depth.mean()
    values = np.column_stack([uv * at_corner[:, None], at_corner])
    attribute = mesh.attributes.new(_HOMOGENEOUS, "FLOAT_VECTOR", "CORNER")
    attribute.data.foreach_set("vector", values.astype(np.float32).reshape(-1))


def _material(source: bpy.types.Image, target: bpy.types.Image) -> bpy.types.Material:
    """A material that emits the source at the positions in the photo; its active node holds the target image."""
    material = bpy.data.materials.new("origami bake")
    nodes, links = without_nodes(material)
    coordinates = nodes.new("ShaderNodeAttribute")
    coordinates.attribute_name = _HOMOGENEOUS
    parts = nodes.new("ShaderNodeSeparateXYZ")
    divided = nodes.new("ShaderNodeVectorMath")
    divided.operation = "DIVIDE"
    depth = nodes.new("ShaderNodeCombineXYZ")
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = source
    texture.interpolation = "Linear"
    texture.extension = "EXTEND"
    emission = nodes.new("ShaderNodeEmission")
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(coordinates.outputs["Vector"], parts.inputs["Vector"])
    for axis in "XYZ":
        links.new(parts.outputs["Z"], depth.inputs[axis])
    links.new(coordinates.outputs["Vector"], divided.inputs[0])
    links.new(depth.outputs["Vector"], divided.inputs[1])
    links.new(divided.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    baked = nodes.new("ShaderNodeTexImage")
    baked.image = target
    nodes.active = baked
    return material
