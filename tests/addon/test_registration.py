"""The add-on unregisters without a trace, and everything that it shows has a name and a description."""

from __future__ import annotations

import dataclasses
import inspect
import re
import types
import typing


def traces() -> dict[str, set[str]]:
    import bpy

    return {
        "types": {name for name in dir(bpy.types) if "origami" in name.lower()},
        "operators": set(dir(bpy.ops.origami)),
        "properties": {
            f"{owner.__name__}.{name}"
            for owner in (bpy.types.Scene, bpy.types.Collection, bpy.types.WindowManager)
            for name in owner.bl_rna.properties.keys()  # noqa: SIM118 - Blender's collection
            if "origami" in name
        },
        "handlers": {
            f"{kind}.{handler.__name__}"
            for kind in dir(bpy.app.handlers)
            if isinstance(getattr(bpy.app.handlers, kind), list)
            for handler in getattr(bpy.app.handlers, kind)
            if "origami" in (getattr(handler, "__module__", "") or "")
        },
        "menus": {
            f"{name}.{function.__module__}"
            for name in dir(bpy.types)
            if hasattr(getattr(bpy.types, name), "draw") and hasattr(getattr(bpy.types, name).draw, "_draw_funcs")
            for function in getattr(bpy.types, name).draw._draw_funcs
            if "origami" in function.__module__
        },
        "manuals": {each.__module__ for each in bpy.utils._manual_map if "origami" in each.__module__},
        "preferences": {
            name
            for name in ("OrigamiPreferences",)
            if bpy.types.AddonPreferences.bl_rna_get_subclass_py(name) is not None
        },
    }


def test_nothing_is_left_behind(empty_scene):
    import bpy
    from origami import register, unregister
    from origami.origami_addon.scene import properties

    if hasattr(bpy.types.Scene, "origami"):  # the command line, run in this process by other tests, leaves them
        properties.unregister()
    before = traces()
    assert not any(before.values())
    for _ in range(2):
        register()
        there = traces()
        assert all(there.values())
        unregister()
        assert traces() == before


def classes() -> list[type]:
    from origami.origami_addon import addon
    from origami.origami_addon.scene import properties

    return [*addon.CLASSES, *properties.CLASSES]


def test_names_are_as_blender_wants_them():
    import bpy

    kinds = {
        bpy.types.Operator: "OT",
        bpy.types.Panel: "PT",
        bpy.types.Menu: "MT",
        bpy.types.UIList: "UL",
        bpy.types.FileHandler: "FH",
    }
    seen = set()
    for each in classes():
        for kind, letters in kinds.items():
            if issubclass(each, kind):
                seen.add(kind)
                assert re.fullmatch(rf"[A-Z][A-Z0-9_]*_{letters}_[a-z0-9_]+", each.__name__)
        if issubclass(each, bpy.types.Operator):
            name = each.__name__.partition("_OT_")[2]
            assert each.bl_idname.partition(".")[2] == name
    assert seen == set(kinds)


def test_every_button_and_setting_is_explained(add_on):
    import bpy

    for each in classes():
        if issubclass(each, bpy.types.Operator):
            rna = getattr(bpy.ops.origami, each.bl_idname.partition(".")[2]).get_rna_type()
            assert rna.description, each
            assert not rna.description.endswith("."), each
            assert rna.name == rna.name.strip() and rna.name[0].isupper(), each
        elif issubclass(each, bpy.types.PropertyGroup):
            rna = each.bl_rna
        else:
            continue
        for key, shown in rna.properties.items():
            if key in ("rna_type", "name", "bl_system_properties") or not (each.__annotations__.get(key)):
                continue
            assert shown.name, f"{each.__name__}.{key}"
            assert shown.description and not shown.description.endswith("."), f"{each.__name__}.{key}"
            for item in getattr(shown, "enum_items", ()):
                assert item.name, f"{each.__name__}.{key}"


def test_settings_go_to_blender_and_back(add_on):
    import bpy
    from origami.origami_addon.scene.settings_group import settings_from, settings_to_json
    from origami.origami_addon.settings import ImageSettings, PageSettings, RunSettings
    from origami.origami_addon.settings_json import from_json

    group = bpy.data.collections.new("any").origami.settings
    assert from_json(settings_to_json(group)) == RunSettings()
    for size in ((210.0, 297.0), (80.3, None), (123.4, 55.5), None):
        changed = RunSettings(
            page=PageSettings(size, "270"),
            image=ImageSettings(dpi=None if size is None else 333.0, source="reference", light="white", bake=True),
            reference="ü 3.jpg",
        )
        changed = dataclasses.replace(
            changed,
            sfm=dataclasses.replace(changed.sfm, seed=7, threads=1),
            surface=dataclasses.replace(changed.surface, method="poisson", smoothness=0.3),
            flatten=dataclasses.replace(changed.flatten, method="lscm", ridge_rows=True),
        )
        settings_from(group, changed)
        assert from_json(settings_to_json(group)) == changed


def test_every_preset_can_be_used(add_on):
    import bpy
    from origami.origami_addon.presets import PRESETS, apply_preset
    from origami.origami_addon.scene.settings_group import settings_to_json
    from origami.origami_addon.settings_json import from_json

    group = bpy.data.collections.new("any").origami.settings
    results = set()
    for name in PRESETS:
        apply_preset(group, name)
        settings = from_json(settings_to_json(group))
        settings.check()
        results.add(settings)
    assert len(results) == len(PRESETS)


def test_a_preset_forgets_the_one_before(add_on):
    import bpy
    from origami.origami_addon.presets import apply_preset
    from origami.origami_addon.scene.settings_group import settings_to_json

    group = bpy.data.collections.new("any").origami.settings
    apply_preset(group, "sheet")
    plain = settings_to_json(group)
    apply_preset(group, "archive")
    apply_preset(group, "receipt")
    apply_preset(group, "sheet")
    assert settings_to_json(group) == plain


def test_a_preset_that_says_nothing_of_the_page_leaves_it_alone(add_on):
    import bpy
    from origami.origami_addon.presets import apply_preset
    from origami.origami_addon.scene.settings_group import settings_to_json

    group = bpy.data.collections.new("any").origami.settings
    group.page.paper, group.page.turn, group.image.light, group.surface.smoothness = "A5", "90", "white", 3.0
    apply_preset(group, "archive")
    content = settings_to_json(group)
    assert content["page"] == {"paper_size_mm": [148, 210], "turn": "90"}
    assert content["image"]["light"] == "white"
    assert content["surface"]["smoothness"] == 1.0
    apply_preset(group, "us_letter")
    assert settings_to_json(group)["page"]["paper_size_mm"] == [215.9, 279.4]


def test_files_to_export_are_ticked_one_by_one(add_on):
    import bpy
    from origami.origami_addon.export.outputs import KINDS

    names = [each.identifier for each in bpy.ops.origami.export.get_rna_type().properties]
    ticks = [name for name in names if name.startswith("write_")]
    assert ticks == [f"write_{kind}" for kind in KINDS]
    ticked = {name: function for _, name, kind, function in callbacks() if kind == "set"}
    chosen = types.SimpleNamespace(kinds={"tiff"})
    ticked["write_obj"](chosen, True)
    assert chosen.kinds == {"tiff", "obj"}
    ticked["write_tiff"](chosen, False)
    assert chosen.kinds == {"obj"}


_CALLBACKS = ("poll", "items", "get", "set", "update", "search")


def callbacks() -> list[tuple[type, str, str, typing.Callable]]:
    """Class, property and kind of each callback of a property, from annotations evaluated as Blender does."""
    return [
        (each, name, kind, given.keywords[kind])
        for each in classes()
        for name, given in typing.get_type_hints(each).items()
        for kind in _CALLBACKS
        if callable(getattr(given, "keywords", {}).get(kind))
    ]


def test_what_blender_calls_of_a_property_finds_its_names(add_on):
    """Blender evaluates annotations in the class's namespace, where the module's names are not visible."""
    import bpy
    from origami.origami_addon.export.outputs import KINDS
    from origami.origami_addon.scene.document import new_document

    document = new_document("sheet", bpy.context.scene).collection
    plain = bpy.data.collections.new("plain")
    shown = bpy.context.scene.origami
    answers = {("OrigamiScene", "document", "poll"): [((shown, document), True), ((shown, plain), False)]}
    place = bpy.data.collections.find(document.name)
    answers["OrigamiScene", "place", "set"] = [((shown, place), None)]
    answers["OrigamiScene", "place", "get"] = [((shown,), place)]
    answers["OrigamiDocument", "title", "set"] = [((document.origami, "sheet"), None)]
    answers["OrigamiDocument", "title", "get"] = [((document.origami,), "sheet")]
    for kind in KINDS:
        one, none = types.SimpleNamespace(kinds={kind}), types.SimpleNamespace(kinds=set())
        answers["ORIGAMI_OT_export", f"write_{kind}", "get"] = [((one,), True), ((none,), False)]
        answers["ORIGAMI_OT_export", f"write_{kind}", "set"] = [((none, True), None), ((one, False), None)]
    found = {(each.__name__, name, kind): function for each, name, kind, function in callbacks()}
    assert found.keys() == answers.keys()
    for key, cases in answers.items():
        for given, answer in cases:
            assert found[key](*given) == answer
    shown.document = document
    assert shown.document == document


def test_every_poll_answers(add_on, capfd):
    """For operators, panels and menus, with and without a document; Blender must not print anything."""
    import bpy
    from origami.origami_addon.scene.document import new_document

    for _ in range(2):
        for each in classes():
            if issubclass(each, bpy.types.Operator):
                getattr(bpy.ops.origami, each.bl_idname.partition(".")[2]).poll()
            elif hasattr(each, "poll"):
                each.poll(bpy.context)
            elif hasattr(each, "poll_drop"):
                each.poll_drop(bpy.context)
        bpy.context.scene.origami.document = new_document("sheet", bpy.context.scene).collection
    output = capfd.readouterr()
    assert "Traceback" not in output.err + output.out


_TAKES_AN_OPERATOR = re.compile(r"\.(modal_handler_add|fileselect_add|invoke_\w+)\(")


def test_no_operator_is_in_blenders_hands_twice():
    """Blender frees an operator once for each modal run, dialog or file browser."""
    import bpy
    from origami.origami_addon.operators import CLASSES
    from origami.origami_addon.operators.job_operator import JobOperator

    operators = [each for each in CLASSES if issubclass(each, bpy.types.Operator)]
    jobs = [each for each in operators if issubclass(each, JobOperator)]
    assert len(jobs) > 5 and any(hasattr(each, "modal") for each in operators if each not in jobs)
    for each in operators:
        own = [base for base in each.__mro__ if base.__module__.startswith("origami")]
        places = [found for base in own for found in _TAKES_AN_OPERATOR.findall(inspect.getsource(base))]
        assert len(places) <= 1, (each, places)
    for each in jobs:
        for name in ("invoke", "execute", "modal", "cancel"):
            assert getattr(each, name) is getattr(JobOperator, name), (each, name)
