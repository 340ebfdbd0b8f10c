"""Tiny random networks of the classes of transformers that are read, saved as their authors save theirs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import torch
import transformers
from tokenizers import Tokenizer, models, pre_tokenizers

CITYSCAPES = (
    "road sidewalk building wall fence pole traffic_light traffic_sign vegetation terrain sky person rider car truck "
    "bus train motorcycle bicycle"
)
NAMES = dict(enumerate(name.replace("_", " ") for name in CITYSCAPES.split()))
SWIN = {"embed_dim": 8, "depths": [1, 1, 1, 1], "num_heads": [1, 1, 2, 2], "window_size": 4, "image_size": 64}
STAGES = ["stage1", "stage2", "stage3", "stage4"]


def save(folder: Path, network: Any, *processors: Any) -> Path:
    """The folder, with the network and its processors in it."""
    network.save_pretrained(folder)
    for processor in processors:
        processor.save_pretrained(folder)
    return folder


def depth_anything(folder: Path, **fields: Any) -> Path:
    """Depth Anything V2."""
    torch.manual_seed(0)
    backbone = transformers.Dinov2Config(
        hidden_size=16, num_hidden_layers=2, num_attention_heads=2, image_size=28, patch_size=14,
        out_features=["stage1", "stage2"], apply_layernorm=True, reshape_hidden_states=False,
    )  # fmt: skip
    config = transformers.DepthAnythingConfig(
        backbone_config=backbone, patch_size=14, reassemble_hidden_size=16, reassemble_factors=[2, 1],
        neck_hidden_sizes=[8, 8], fusion_hidden_size=8, head_hidden_size=8,
        **{"depth_estimation_type": "metric", "max_depth": 80} | fields,
    )  # fmt: skip
    processor = transformers.DPTImageProcessorPil(
        size={"height": 56, "width": 56}, keep_aspect_ratio=True, ensure_multiple_of=14
    )
    return save(folder, transformers.DepthAnythingForDepthEstimation(config), processor)


def glpn(folder: Path) -> Path:
    """GLPN, which says nothing of its unit."""
    torch.manual_seed(0)
    config = transformers.GLPNConfig(
        hidden_sizes=[4, 4, 8, 8], depths=[1, 1, 1, 1], num_attention_heads=[1, 1, 2, 2], decoder_hidden_size=8
    )
    return save(folder, transformers.GLPNForDepthEstimation(config), transformers.GLPNImageProcessorPil())


def segformer(folder: Path, names: dict[int, str] | None = None, **fields: Any) -> Path:
    """SegFormer."""
    torch.manual_seed(0)
    config = transformers.SegformerConfig(
        hidden_sizes=[4, 4, 8, 8], depths=[1, 1, 1, 1], num_attention_heads=[1, 1, 2, 2], decoder_hidden_size=8,
        **({"id2label": NAMES if names is None else names} | fields),
    )  # fmt: skip
    processor = transformers.SegformerImageProcessorPil(size={"height": 64, "width": 64})
    return save(folder, transformers.SegformerForSemanticSegmentation(config), processor)


def mask2former(folder: Path) -> Path:
    """Mask2Former."""
    torch.manual_seed(0)
    config = transformers.Mask2FormerConfig(
        backbone_config=transformers.SwinConfig(**SWIN, out_features=STAGES), feature_size=32, mask_feature_size=32,
        hidden_dim=32, encoder_feedforward_dim=32, dim_feedforward=32, encoder_layers=1, decoder_layers=2,
        num_attention_heads=2, num_queries=10, id2label=NAMES,
    )  # fmt: skip
    processor = transformers.Mask2FormerImageProcessorPil(size={"height": 64, "width": 64})
    return save(folder, transformers.Mask2FormerForUniversalSegmentation(config), processor)


def eomt(folder: Path) -> Path:
    """EoMT, which cuts a wide picture into squares."""
    torch.manual_seed(0)
    config = transformers.EomtConfig(
        hidden_size=16, num_hidden_layers=3, num_attention_heads=2, image_size=64, patch_size=16, num_blocks=1,
        num_upscale_blocks=1, num_queries=10, mlp_ratio=2, id2label=NAMES,
    )  # fmt: skip
    processor = transformers.EomtImageProcessorPil(
        size={"shortest_edge": 64, "longest_edge": None}, do_split_image=True, do_pad=False
    )
    return save(folder, transformers.EomtForUniversalSegmentation(config), processor)


def oneformer(folder: Path) -> Path:
    """OneFormer, which reads what it is to do."""
    torch.manual_seed(0)
    config = transformers.OneFormerConfig(
        backbone_config=transformers.SwinConfig(**SWIN, out_features=STAGES), text_encoder_vocab_size=20,
        text_encoder_width=32, text_encoder_num_layers=1, text_encoder_context_length=8, task_seq_len=8,
        max_seq_len=8, hidden_dim=32, conv_dim=32, mask_dim=32, encoder_feedforward_dim=32, dim_feedforward=32,
        encoder_layers=1, decoder_layers=2, num_attention_heads=2, num_queries=10, query_dec_layers=1,
        text_encoder_proj_layers=1, is_training=False, id2label=NAMES,
    )  # fmt: skip
    folder.mkdir(parents=True)
    classes = {str(number): {"name": name, "isthing": int(number > 10)} for number, name in NAMES.items()}
    (folder / "classes.json").write_text(json.dumps(classes))
    pictures = transformers.OneFormerImageProcessorPil(
        size={"shortest_edge": 64, "longest_edge": 128},
        repo_path=str(folder),
        class_info_file="classes.json",
        num_text=2,
    )
    words = {word: k for k, word in enumerate(["<pad>", "the", "task", "is", "semantic", "<unk>"])}
    tokenizer = Tokenizer(models.WordLevel(words, unk_token="<unk>"))
    tokenizer.pre_tokenizer = pre_tokenizers.Whitespace()
    fast = transformers.PreTrainedTokenizerFast(tokenizer_object=tokenizer, pad_token="<pad>", unk_token="<unk>")
    processor = transformers.OneFormerProcessor(pictures, fast, max_seq_length=8, task_seq_length=8)
    return save(folder, transformers.OneFormerForUniversalSegmentation(config), processor)


def sam(folder: Path) -> Path:
    """SAM."""
    torch.manual_seed(0)
    attention = {"num_hidden_layers": 1, "num_attention_heads": 2, "mlp_dim": 16}
    config = transformers.SamConfig(
        vision_config={
            "hidden_size": 16, "image_size": 64, "patch_size": 8, "output_channels": 8, "global_attn_indexes": [0],
            "window_size": 0, "num_pos_feats": 4, **attention,
        },
        prompt_encoder_config={"hidden_size": 8, "image_size": 64, "patch_size": 8, "mask_input_channels": 4},
        mask_decoder_config={"hidden_size": 8, "iou_head_hidden_dim": 8, **attention},
    )  # fmt: skip
    pictures = transformers.SamImageProcessorPil(size={"longest_edge": 64}, pad_size={"height": 64, "width": 64})
    return save(folder, transformers.SamModel(config), transformers.SamProcessor(pictures))
