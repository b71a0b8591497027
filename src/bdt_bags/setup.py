"""Build file of bdt_bags, for colcon and for pip; what package.xml says is not said again."""

from pathlib import Path
from xml.etree import ElementTree as ET

from setuptools import find_packages, setup

package = ET.parse(Path(__file__).with_name("package.xml"))
name = package.findtext("name")
maintainer = package.find("maintainer")

setup(
    name=name,
    version=package.findtext("version"),
    description=package.findtext("description"),
    license=package.findtext("license"),
    maintainer=maintainer.text,
    maintainer_email=maintainer.get("email"),
    python_requires=">=3.11",
    packages=find_packages(),
    package_data={name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    install_requires=[
        "bdt_msgs_py",
        "apsw",
        "backports.zstd; python_version < '3.14'",
        "lz4>=4",
        "mcap>=1.2",
        "numpy>=1.26",
        "pyyaml>=6",
        "rosbags>=0.11",
        "ruamel.yaml>=0.17",
        "zstandard>=0.22",
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "recorder_node = bdt_bags.recorder.recorder_node:main",
        ],
        "bdt.command": [
            "record = bdt_bags.commands.record:COMMAND",
            "recover = bdt_bags.commands.recover:COMMAND",
        ],
        "bdt.node": [
            "recorder = bdt_bags.recorder.recorder_node:RecorderNode",
        ],
        "bdt.parameters": [
            "recorder = bdt_bags.recorder.recorder_settings:PARAMETERS",
        ],
    },
)
