import pytest

import report_inputs
from drawn_sketches import DrawnBox


def test_drawn_scenes_hold_objects_apart_from_each_other() -> None:
    for seed in range(5):
        boxes = [shape for shape in report_inputs.drawn_scene(seed) if isinstance(shape, DrawnBox)]
        assert len(boxes) >= 8
        assert len({box.center for box in boxes}) == len(boxes)
    assert report_inputs.drawn_scene(1) != report_inputs.drawn_scene(2)


def test_sketches_are_found_again(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(report_inputs, "SKETCHES", 2)
    report_inputs.report_sketches()
    assert "20 of 20 objects of 2 sketches found within 1 m, and 0 that nobody drew" in capsys.readouterr().out


def test_a_part_without_its_data_is_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("LIDARDRAFT_DATA", raising=False)
    report_inputs.report_images()
    report_inputs.report_clouds()
    assert capsys.readouterr().out.count("  left out: ") == 2
