"""The edits of asset_edits.py: what changes in which asset, and whether a person sees it.

The marks were made before the measurement, except for that of flipped normals, which was `visible` until the images were equal. An image has 320x180 pixels, and a model covers some 150 rows of it, so that 1 % of its bounds is
about 1.5 pixels. `visible`: when the images alternate at 100 %, a person sees an edge that jumps by half a pixel or more, or an area of a
few pixels whose brightness changes by 3 steps of 8 bits or more. `invisible`: no edge moves by a fiftieth of a pixel and no area changes by more
than one step, so that a failure is a false alarm; single pixels of edges change by more, where one of their four samples hits
another surface. `borderline` is anything between: a preset may catch it or not.
"""

import dataclasses
import typing

import asset_changes as change

VISIBLE, INVISIBLE, BORDERLINE = "visible", "invisible", "borderline"


@dataclasses.dataclass
class Edit:
    """`change` edits an Asset in memory; `suffix` and `order` are how it is written; `tool` is a gltf-transform command instead."""
    name: str
    asset: str
    mark: str
    reason: str
    cause: str
    change: typing.Callable | None = None
    frame: int = 0
    suffix: str = ".glb"
    is_order_reversed: bool = False
    tool: tuple = ()


HELMET, DAMAGED, CESIUM, FOX = "scenes/showcase/helmet.gltf", "khronos/DamagedHelmet", "khronos/CesiumMan", "khronos/Fox"
HIKER, LEVEL, DUCK, SUZANNE = "scenes/showcase/character.gltf", "scenes/showcase/level.gltf", "khronos/Duck", "khronos/Suzanne"
BALLS, BOTTLE, LIGHTS = "scenes/material/metal_roughness_row.gltf", "scenes/showcase/bottle.gltf", "scenes/light/two_lights_shadows.gltf"
SPHERES, BLEND, POINT = "khronos/MetalRoughSpheresNoTextures", "khronos/AlphaBlendModeTest", "scenes/light/point.gltf"
SQUARES, BUMPS, CAMERA = "scenes/texture/base_color_srgb.gltf", "scenes/texture/normal_map.gltf", "scenes/camera/perspective.gltf"


# Name, asset, mark, reason, cause, change; frame 0 unless it is named.
EDITS = [
    # Materials.
    Edit("base colour × 0.93", DAMAGED, VISIBLE, "4 steps over the whole model", "material", change.base_color(0.93)),
    Edit("base colour of the coat × 0.93", HELMET, VISIBLE, "4 steps over the shell", "material", change.base_color(0.93)),
    Edit("base colour × 0.98", DAMAGED, BORDERLINE, "1 step", "material", change.base_color(0.98)),
    Edit("base colour of one part × 1.15", LEVEL, VISIBLE, "7 steps over the roofs", "material", change.base_color(1.15, "roof")),
    Edit("roughness 1 → 0.3", CESIUM, VISIBLE, "highlights appear", "material", change.pbr(0, roughnessFactor=0.3)),
    Edit("roughness 0.75 → 0.3, one of ten materials", HIKER, VISIBLE, "the jacket shines", "material",
         change.pbr("jacket", roughnessFactor=0.3)),
    Edit("roughness 0.58 → 0.55", FOX, BORDERLINE, "1 step", "material", change.pbr(0, roughnessFactor=0.55)),
    Edit("roughness of one ball 0.4 → 0.5", BALLS, VISIBLE, "reflections blur", "material", change.pbr(5, roughnessFactor=0.5)),
    Edit("metallic 0 → 1", FOX, VISIBLE, "colour of all highlights", "material", change.pbr(0, metallicFactor=1)),
    Edit("emission removed", DAMAGED, VISIBLE, "lights go out", "material", change.without(0, "emissiveTexture")),
    Edit("emission of a lamp × 0.5", HELMET, VISIBLE, "lamps of 10 pixels dim", "material",
         change.material("lamp", emissiveFactor=[0.5, 0.4, 0.25])),
    Edit("emissive strength 4 → 3", "khronos/EmissiveStrengthTest", VISIBLE, "a quarter less light", "material",
         change.extension("Emit4", "KHR_materials_emissive_strength", emissiveStrength=3)),
    Edit("blend → opaque", BLEND, VISIBLE, "a surface fills in", "material", change.material("MatBlend", alphaMode="OPAQUE")),
    Edit("alpha cutoff 0.75 → 0.6", BLEND, VISIBLE, "edges move by a pixel", "material", change.material("MatCutoff75", alphaCutoff=0.6)),
    Edit("normal scale 1 → 0.5", BUMPS, VISIBLE, "relief flattens", "material",
         change.material("bumpy", normalTexture={"index": 0, "scale": 0.5})),
    Edit("double-sided → single-sided", "scenes/material/double_sided.gltf", VISIBLE, "back faces turn black or vanish", "material",
         change.material("double", doubleSided=False)),
    Edit("index of refraction 1.5 → 1.45", "scenes/material/ior_row.gltf", VISIBLE, "refracted edges move by pixels", "material",
         change.extension(5, "KHR_materials_ior", ior=1.45)),
    Edit("transmission 1 → 0.8", BOTTLE, VISIBLE, "glass turns milky", "material",
         change.extension("glass", "KHR_materials_transmission", transmissionFactor=0.8)),
    Edit("clear coat removed", "khronos/ClearCoatCarPaint", VISIBLE, "reflections vanish", "material",
         change.extension(0, "KHR_materials_clearcoat", clearcoatFactor=0)),
    Edit("gold → copper on small coins", LEVEL, VISIBLE, "another hue on a few pixels", "material",
         change.pbr("gold", baseColorFactor=[0.63, 0.26, 0.12, 1])),
    Edit("one sphere of 98 × 0.85", SPHERES, VISIBLE, "9 steps over 12 pixels", "material", change.base_color(0.85, "mat_3")),
    # Textures.
    Edit("two textures swapped", SQUARES, VISIBLE, "other images", "material", change.swap_textures),
    Edit("texture halved, box filter", DAMAGED, INVISIBLE, "texels stay far smaller than a pixel", "material",
         change.texture(0, change.resized(2))),
    Edit("texture of 512 → 64", DUCK, VISIBLE, "the eye blurs", "material", change.texture(0, change.resized(8))),
    Edit("texture as JPEG, quality 90", DUCK, BORDERLINE, "1 to 2 steps", "material",
         change.texture(0, change.channels((0, 1, 2)), "JPEG", quality=90)),
    Edit("texture as JPEG, quality 50", DUCK, BORDERLINE, "2 to 4 steps in blocks", "material",
         change.texture(0, change.channels((0, 1, 2)), "JPEG", quality=50)),
    Edit("red and blue swapped", DUCK, VISIBLE, "another hue", "material", change.texture(0, change.channels((2, 1, 0)))),
    Edit("texture upside down", CESIUM, VISIBLE, "other colours everywhere", "material",
         change.texture(0, lambda image: image.transpose(1))),
    Edit("texels + 1 of 255", DUCK, INVISIBLE, "at most 1 step", "material", change.texture(0, change.values(lambda texels: texels + 1))),
    Edit("texels + 6 of 255", CESIUM, VISIBLE, "3 to 6 steps over the model", "material",
         change.texture(0, change.values(lambda texels: texels + 6))),
    Edit("normal map with −Y", DAMAGED, VISIBLE, "relief turns inside out", "material",
         change.texture(4, change.values(lambda texels: abs(texels - [0, 255, 0])))),
    Edit("roughness and metallic swapped", DAMAGED, VISIBLE, "metal turns rough", "material",
         change.texture(1, change.channels((0, 2, 1)))),
    # Normals and texture coordinates.
    Edit("normals flipped", SUZANNE, INVISIBLE, "Rayframe turns them to the viewer (docs/shading.md)", "surface",
         change.vertices("NORMAL", lambda normals: -normals)),
    Edit("winding reversed", SUZANNE, VISIBLE, "front faces vanish", "surface", change.reverse_winding),
    Edit("normals flat", DUCK, VISIBLE, "facets", "surface", change.flatten_normals),
    Edit("normals dropped", SUZANNE, VISIBLE, "facets", "surface", change.drop_normals),
    Edit("normals rounded to 10 bits", SUZANNE, INVISIBLE, "0.1 degrees, at most 1 step", "surface", change.rounded_normals(511)),
    Edit("UVs + 0.1", CESIUM, VISIBLE, "the texture slides", "surface", change.vertices("TEXCOORD_0", lambda uvs: uvs + 0.1)),
    Edit("UVs × 1.1", DUCK, VISIBLE, "eye and beak slide", "surface", change.vertices("TEXCOORD_0", lambda uvs: uvs * 1.1)),
    Edit("UVs + half a texel of 2048", DAMAGED, BORDERLINE, "an eighth of a pixel", "surface",
         change.vertices("TEXCOORD_0", lambda uvs: uvs + 0.5 / 2048)),
    # Single meshes of many.
    Edit("barrel removed", LEVEL, VISIBLE, "an object vanishes", "geometry", change.remove(26)),
    Edit("lamp removed", HELMET, VISIBLE, "an object vanishes", "geometry", change.remove("lamp left")),
    Edit("ball removed", BALLS, VISIBLE, "an object vanishes", "geometry", change.remove(4)),
    Edit("sphere of 98 removed", SPHERES, VISIBLE, "an object vanishes", "geometry", change.remove("m50%_r50%")),
    Edit("chin guard moved by 1 %", HELMET, VISIBLE, "edges jump by 1.5 pixels", "geometry", change.move("chin guard", 0.01, 1)),
    Edit("chin guard moved by 0.1 %", HELMET, BORDERLINE, "0.15 pixels", "geometry", change.move("chin guard", 0.001, 1)),
    Edit("bridge moved by 1 %", LEVEL, VISIBLE, "edges jump by a pixel", "geometry", change.move("bridge", 0.01, 1)),
    Edit("visor × 1.05", HELMET, VISIBLE, "edges jump by 2 pixels", "geometry", change.scale("visor", 1.05)),
    # Joints and clips.
    Edit("head turned by 5°", FOX, VISIBLE, "the snout moves by pixels", "geometry", change.rotate_joint("b_Head_05", 5), frame=6),
    Edit("forearm turned by 5°", HIKER, VISIBLE, "the hand moves by 1.5 pixels", "geometry",
         change.rotate_joint("forearm left", 5), frame=6),
    Edit("torso turned by 5°", CESIUM, VISIBLE, "arms move by pixels", "geometry", change.rotate_joint("torso_joint_3", 5), frame=12),
    Edit("weights of a joint lost", FOX, VISIBLE, "a leg stays behind", "geometry", change.wrong_weights("b_RightForeArm_07"), frame=6),
    Edit("clips deleted", CESIUM, VISIBLE, "the rest pose", "geometry", change.delete_clips, frame=12),
    Edit("keys later by a frame", CESIUM, VISIBLE, "legs move by pixels", "geometry",
         change.key_times(lambda times: times + 1 / 24), frame=12),
    Edit("clip slower by 10 %", FOX, VISIBLE, "another pose", "geometry", change.key_times(lambda times: times * 1.1), frame=12),
    Edit("linear → step keys", "khronos/BoxAnimated", VISIBLE, "the box jumps", "geometry", change.interpolation("STEP"), frame=12),
    # Lights.
    Edit("one light of two × 0.9", LIGHTS, VISIBLE, "5 steps on half of the floor", "light", change.dimmed(0, 0.9)),
    Edit("the only light × 0.9", POINT, VISIBLE, "5 steps", "light", change.dimmed(0, 0.9)),
    Edit("the only light × 0.99", POINT, BORDERLINE, "1 step", "light", change.dimmed(0, 0.99)),
    Edit("warmer light", POINT, VISIBLE, "another hue", "light", change.light(0, color=[1, 0.9, 0.8])),
    Edit("light removed", LIGHTS, VISIBLE, "half of the light", "light", change.remove_light(1)),
    Edit("sun × 0.9", LEVEL, VISIBLE, "4 steps where it shines", "light", change.dimmed(0, 0.9)),
    Edit("light moved by 2 %", POINT, VISIBLE, "shadows move by pixels", "light", change.move(6, 0.02)),
    # Cameras.
    Edit("camera moved by 1 %", POINT, VISIBLE, "edges jump by 2 pixels", "camera", change.move_camera(0.01)),
    Edit("camera moved by 1 % before flat colours", CAMERA, VISIBLE, "edges jump by 2 pixels", "camera", change.move_camera(0.01)),
    Edit("camera moved by 0.02 %", POINT, BORDERLINE, "0.05 pixels", "camera", change.move_camera(0.0002)),
    Edit("field of view + 2 %", BALLS, VISIBLE, "edges jump by pixels", "camera", change.field_of_view(1.02)),
    # Precision.
    Edit("positions of 16 bits", DUCK, INVISIBLE, "0.002 pixels", "geometry", change.quantized(16)),
    Edit("positions of 14 bits", SUZANNE, INVISIBLE, "0.01 pixels", "geometry", change.quantized(14)),
    Edit("positions of 12 bits", DUCK, BORDERLINE, "0.04 pixels", "geometry", change.quantized(12)),
    Edit("positions of 7 bits", DUCK, VISIBLE, "1 pixel, and dents", "geometry", change.quantized(7)),
    Edit("noise of 1/100", SUZANNE, VISIBLE, "1.5 pixels", "geometry", change.noise(0.01)),
    Edit("noise of 1/1000", SUZANNE, BORDERLINE, "0.15 pixels", "geometry", change.noise(0.001)),
    Edit("noise of 1/10000", SUZANNE, INVISIBLE, "0.015 pixels", "geometry", change.noise(0.0001)),
    # Compression with loss, by the tool's own settings.
    Edit("Draco", DUCK, INVISIBLE, "positions of 14 bits, normals of 10", "geometry", tool=("draco",)),
    Edit("Draco", DAMAGED, INVISIBLE, "positions of 14 bits, normals of 10", "geometry", tool=("draco",)),
    Edit("meshopt", DUCK, BORDERLINE, "positions of 14 bits, normals of 8: up to 0.5 degrees", "geometry", tool=("meshopt",)),
    Edit("quantize", SUZANNE, BORDERLINE, "positions of 14 bits, normals of 10, UVs of 12", "geometry", tool=("quantize",)),
    # Lossless re-encodings.
    Edit("PNG re-compressed", DUCK, INVISIBLE, "equal texels", "none", change.recompress_images),
    Edit(".glb → .gltf", FOX, INVISIBLE, "equal content", "none", change.same, frame=6, suffix=".gltf"),
    Edit(".gltf → .glb", HELMET, INVISIBLE, "equal content", "none", change.same),
    Edit("buffer views reversed", CESIUM, INVISIBLE, "equal content", "none", change.same, frame=12, is_order_reversed=True),
    Edit("nodes reversed", HELMET, INVISIBLE, "equal scene", "none", change.renumber("nodes", change.uses_of_nodes)),
    Edit("meshes reversed", HELMET, INVISIBLE, "equal scene, other ids", "none", change.renumber("meshes", change.uses_of_meshes)),
    Edit("materials reversed", LEVEL, INVISIBLE, "equal scene, other ids", "none", change.renumber("materials", change.uses_in_primitives)),
    Edit("triangles shuffled", SUZANNE, INVISIBLE, "equal surface", "none", change.shuffle_triangles),
    Edit("triangles' corners rotated", SUZANNE, INVISIBLE, "equal surface", "none", change.rotate_triangles),
    Edit("vertices shuffled, wide indices", DUCK, INVISIBLE, "equal surface", "none", change.shuffle_vertices),
    Edit("wide indices", DAMAGED, INVISIBLE, "equal surface", "none", change.wide_indices),
    Edit("unused material and mesh removed", HELMET, INVISIBLE, "equal scene, other ids", "none", change.add_unused),
    Edit("everything renamed", HIKER, INVISIBLE, "equal scene", "none", change.rename, frame=6),
    Edit("default values written out", HELMET, INVISIBLE, "equal scene", "none", change.write_defaults),
]
