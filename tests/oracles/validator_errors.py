#!/usr/bin/env python3
"""Lists the errors of the Khronos glTF validator that `rayframe info` neither refuses nor warns of, each with the reason.

    python3 tests/oracles/validator_errors.py RAYFRAME FOLDER

FOLDER has glTF files, each with the validator's report beside it as FILE.report.json. Ends with 1 where a file of which the validator
reports an error of severity 0 is accepted without a word and one of its errors has no reason here, or the reason that its object is not
used and the file may use it; and where a run crashes or takes more than 5 s.
"""

import collections
import json
import pathlib
import subprocess
import sys

NOT_READ = "the object is not used; what nothing reads cannot change an image"
LENIENT = "the meaning is clear"
REASONS = {
    "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION": "rotations are normalized",
    "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND": NOT_READ,
    "ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND": NOT_READ,
    "ACCESSOR_INVALID_FLOAT": NOT_READ,
    "ACCESSOR_INVALID_SIGN": "tangents get the nearest sign",
    "ACCESSOR_JOINTS_INDEX_DUPLICATE": "weights of one joint are added",
    "ACCESSOR_JOINTS_INDEX_OOB": NOT_READ,
    "ACCESSOR_MAX_MISMATCH": NOT_READ,
    "ACCESSOR_MIN_MISMATCH": NOT_READ,
    "ACCESSOR_VECTOR3_NON_UNIT": "normals and tangents are normalized",
    "ACCESSOR_WEIGHTS_NEGATIVE": NOT_READ,
    "ACCESSOR_WEIGHTS_NON_NORMALIZED": "weights are normalized",
    "BUFFER_DATA_URI_MIME_TYPE_INVALID": LENIENT,
    "BUFFER_MISSING_GLB_DATA": NOT_READ,
    "BUFFER_VIEW_INVALID_BYTE_STRIDE": "any stride is read",
    "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE": "any stride is read",
    "EMPTY_ENTITY": "an empty list is an absent one",
    "IMAGE_MIME_TYPE_INVALID": "the first bytes of an image tell its format",
    "IMAGE_NON_ENABLED_MIME_TYPE": "the first bytes of an image tell its format",
    "INVALID_JSON": "a byte order mark is skipped",
    "INVALID_URI": NOT_READ,
    "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH": NOT_READ,
    "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT": "an application's own attributes are not read",
    "MESH_PRIMITIVE_NO_TANGENT_SPACE": "tangents are generated",
    "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS": "bounds are computed from the elements",
    "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS": NOT_READ,
    "PATTERN_MISMATCH": NOT_READ,
    "ROTATION_NON_UNIT": "rotations are normalized",
    "TEXTURE_INVALID_IMAGE_MIME_TYPE": "the first bytes of an image tell its format",
    "UNDECLARED_EXTENSION": LENIENT,
    "UNEXPECTED_EXTENSION_OBJECT": "extensions apply where they are defined, and are not looked for elsewhere",
}


# Lists of which one must hold something for an element of the list before to be used.
USERS = {"accessors": ["meshes", "skins", "animations", "nodes"], "buffers": ["bufferViews"], "images": ["textures"]}


def document(file):
    """The JSON of a .gltf or .glb file."""
    data = file.read_bytes()
    if data[:4] == b"glTF":
        data = data[20:20 + int.from_bytes(data[12:16], "little")]
    return json.loads(data)


def is_unused(root, pointer):
    """Whether nothing in the document can use the object at the pointer."""
    kind, *rest = pointer.strip("/").split("/")
    if kind == "animations" and rest[1:2] == ["channels"]:
        return "node" not in root["animations"][int(rest[0])]["channels"][int(rest[2])]["target"]
    return kind in USERS and not any(root.get(user) for user in USERS[kind])


def outcome(rayframe, file):
    """`refused`, `warned` or `silent`; anything else is a fault."""
    try:
        run = subprocess.run([rayframe, "info", "--json", file], capture_output=True, text=True, timeout=5)
    except subprocess.TimeoutExpired:
        return "takes more than 5 s"
    if run.returncode in (65, 66, 77):
        return "panicked" if "please report" in run.stderr else "refused"
    if run.returncode != 0:
        return f"ends with {run.returncode}"
    return "warned" if json.loads(run.stdout).get("not_supported") else "silent"


def main():
    rayframe, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    outcomes, silent, faults = collections.Counter(), collections.Counter(), []
    for report in sorted(folder.rglob("*.report.json")):
        file = report.with_name(report.name.removesuffix(".report.json"))
        messages = json.loads(report.read_text())["issues"]["messages"] if file.exists() else []
        codes = {message["code"] for message in messages if message["severity"] == 0}
        if not codes:
            continue
        found = outcome(rayframe, file)
        outcomes[found] += 1
        if found == "silent":
            silent.update(codes)
            faults += [f"{file}: {code} has no reason" for code in sorted(codes - REASONS.keys())]
            unread = {message["pointer"] for message in messages if REASONS.get(message["code"]) == NOT_READ and message["severity"] == 0}
            faults += [f"{file}: {pointer} may be used" for pointer in sorted(unread) if not is_unused(document(file), pointer)]
        elif found not in ("refused", "warned"):
            faults.append(f"{file}: {found}")
    print(", ".join(f"{count} {name}" for name, count in sorted(outcomes.items())))
    for code, count in sorted(silent.items()):
        print(f"{count:>4} {code}: {REASONS.get(code, '?')}")
    print("\n".join(faults) or "0 without a reason")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
