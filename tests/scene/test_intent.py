"""Intent: JSON both ways, what files of others may hold, edits, and layouts of the first schema."""

import dataclasses
import json
from pathlib import Path

import pytest

from lidardraft import (
    Asked,
    FormatError,
    Intent,
    Layout,
    LayoutError,
    Primitive,
    Sensor,
    SequenceSimulator,
    detail,
    edit,
    layout_from_blender,
    layout_from_glb,
    layout_from_text,
    surround,
)
from lidardraft.formats.blender_script import blender_script
from lidardraft.formats.glb import write_glb
from lidardraft.scene.weather import WEATHERS, weather_of

SMALL = Sensor(name="small", elevations=(0.02, -0.05, -0.1, -0.2), columns=64)
SENTENCE = "a red car overtaking a truck ahead, some pedestrians crossing, no bus, heavy rain downtown, a llama"
DRAFT = layout_from_text(SENTENCE, seed=3)


def test_the_intent_of_a_sentence_says_what_each_object_was_asked_to_be() -> None:
    intent = DRAFT.intent
    assert intent.sentence == SENTENCE
    assert (intent.road, intent.district, intent.weather) == ("straight", "urban", "heavy-rain")
    assert set(intent.denied) == {"bus", "car", "truck"}
    car, truck, person = (intent.of(name) for name in ("car_1", "truck_1", "person_1"))
    assert (car.kind, car.motion, car.paint, car.overtakes) == ("car", "overtakes", "light", (truck.group,))
    assert (person.counted, car.counted) == (False, True)
    assert person.heading is not None
    assert person.heading.startswith("across")
    assert intent.of("car_9") == Asked()
    assert weather_of(intent.weather) == WEATHERS["heavy-rain"]
    assert weather_of(None).extinction == 0.0


def test_an_intent_is_the_same_after_its_json() -> None:
    for intent in (Intent(), DRAFT.intent, Intent(headed=False, around="alley", ego=Asked(speed=0.0))):
        assert Intent.from_dict(json.loads(json.dumps(intent.to_dict()))) == intent
    assert Intent().to_dict() == {}
    assert Intent(ego=Asked(motion="brakes")).to_dict() == {"ego": {"motion": "brakes"}}


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"colour": 1}, "intent: unknown field 'colour'"),
        ({"weather": "frogs"}, "intent: weather is 'frogs'; it must be one of light-rain"),
        ({"activity": ["busy"]}, "intent: activity is .'busy'.; it must be one of empty"),
        ({"denied": "bus"}, "intent: denied is 'bus'; it must be a list"),
        ({"denied": [1]}, "intent: denied: kind is 1; it must be text"),
        ({"road": 1}, "intent: road is 1; it must be text"),
        ({"headed": 1}, "intent: headed is 1; it must be true or false"),
        ({"ego": 5}, "intent: ego: 5 is not a JSON object"),
        ({"ego": {"speed": -1}}, "intent: ego: speed is -1; it must be 0 to 70 m/s"),
        ({"objects": []}, r"intent: \[\] is not a JSON object"),
        ({"objects": {"car_1": {"heading": "up"}}}, "intent: car_1: heading is 'up'; it must be one of with"),
        ({"objects": {"car_1": {"overtakes": [-1]}}}, "intent: car_1: group is -1; it must be the number of a group"),
        ({"objects": {"car_1": {"paint": "gold"}}}, "intent: car_1: paint is 'gold'; it must be one of light"),
        ({"objects": {"car_1": {"counted": None}}}, "intent: car_1: counted is None; it must be true or false"),
        ({"objects": {"car_1": {"motion": 3}}}, "intent: car_1: motion is 3; it must be one of brakes"),
    ],
)
def test_an_intent_that_cannot_be_is_one_line(tmp_path: Path, fields: dict[str, object], message: str) -> None:
    document = json.loads(DRAFT.to_json())
    file = tmp_path / "a.layout.json"
    file.write_text(json.dumps(document | {"intent": fields}))
    with pytest.raises((FormatError, LayoutError), match=f"a.layout.json: {message}") as caught:
        Layout.load(file)
    assert "\n" not in str(caught.value)


def test_kinds_and_districts_that_nobody_knows_are_named_when_they_are_needed() -> None:
    for fields, message in (
        ({"denied": ("dragon",)}, "intent: denied: kind is 'dragon'; it must be one of "),
        ({"district": "moon"}, "intent: district is 'moon'; it must be one of residential"),
    ):
        layout = dataclasses.replace(DRAFT, intent=dataclasses.replace(DRAFT.intent, **fields))
        with pytest.raises(LayoutError, match=message):
            surround(layout)


def test_what_a_layout_holds_is_checked() -> None:
    for fields, message in (
        ({"intent": {}}, r"intent is \{\}; it must be an Intent"),
        ({"roads": 3}, "roads is 3; it must be a RoadNetwork or None"),
        ({"notes": "one"}, "notes is 'one'; it must be a list"),
        ({"notes": [1]}, r"notes is \[1\]; it must be lines of text"),
    ):
        with pytest.raises(LayoutError, match=message):
            Layout(**fields)  # type: ignore[arg-type]
    assert Layout(notes=["a"]).noted("a", "b").notes == ("a", "b")  # type: ignore[arg-type]


def test_an_object_that_is_gone_is_not_in_the_intent_and_one_that_is_renamed_is() -> None:
    gone = edit.remove(DRAFT, "car_1")
    assert gone.intent.objects.keys() == DRAFT.intent.objects.keys() - {"car_1"}
    assert gone.intent.denied == DRAFT.intent.denied  # one car was asked for, still
    renamed = edit.replace(DRAFT, "car_1", id="taxi")
    assert renamed.intent.of("taxi") == DRAFT.intent.of("car_1")
    assert "car_1" not in renamed.intent.objects
    part = edit.replace(layout_from_text("a cyclist ahead"), "*.rider", id="somebody")
    assert part.intent.objects.keys() == {"bicycle_1"}  # of which a part is left
    added = edit.add(DRAFT, Primitive(shape="box", center=(9, 9, 1), size=(4, 2, 2), label="car", id="car_2"))
    assert added.intent == DRAFT.intent
    for layout in (edit.move(DRAFT, "car_1", (1.0, 0.0, 0.0)), detail(DRAFT), DRAFT.noted("one")):
        assert layout.intent == DRAFT.intent
    whole = surround(DRAFT, seed=1)
    assert dataclasses.replace(whole.intent, around=None) == DRAFT.intent
    assert whole.intent.around == "urban"


def test_who_overtakes_may_be_taken_away() -> None:
    """What is left of a scene moves."""
    for name in ("car_1", "truck_1"):
        tracks = SequenceSimulator(edit.remove(DRAFT, name), SMALL, frames=2, hz=1).tracks
        assert name not in tracks.actors


def test_all_of_a_layout_travels_in_files_models_and_scripts(tmp_path: Path) -> None:
    whole = DRAFT.noted("a note")
    assert Layout.from_json(whole.to_json()) == whole
    write_glb(tmp_path / "a.glb", whole)
    for found in (layout_from_glb(tmp_path / "a.glb"), layout_from_blender(blender_script(whole))):
        for name in ("provenance", "coverage", "roads", "intent", "notes"):
            assert getattr(found, name) == getattr(whole, name)
