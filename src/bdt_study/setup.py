"""Build file of bdt_study, for colcon and for pip; what package.xml says is not said again."""

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
    package_data={
        name: [
            "py.typed",
            "benchmarks/*.c",
            "calibration/*.html",
            "reproduction/*.html",
            "studies/*.yaml",
            "sweep/*.html",
            "sweep/*.js",
        ]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    install_requires=[
        "bdt_analysis",
        "bdt_bags",
        "bdt_controller",
        "bdt_msgs_py",
        "bdt_plant",
        "bdt_twin",
        "control>=0.10",
        "matplotlib>=3.6",
        "numba>=0.58",
        "numpy>=1.26",
        "pyyaml>=6",
        "rich>=13",
        "scipy>=1.11",
    ],
    extras_require={"sweep": ["distributed>=2024.8", "pyarrow>=14", "salib>=1.4"]},
    zip_safe=False,
    entry_points={
        "bdt.command": [
            "bench = bdt_study.commands.bench:COMMAND",
            "calibrate = bdt_study.commands.calibrate:COMMAND",
            "design = bdt_study.commands.design:COMMAND",
            "evaluate = bdt_study.commands.evaluate:COMMAND",
            "reproduce = bdt_study.commands.reproduce:COMMAND",
            "sweep = bdt_study.commands.sweep:COMMAND",
            "tune = bdt_study.commands.tune:COMMAND",
        ],
    },
)
