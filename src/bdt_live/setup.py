"""Build file of bdt_live, for colcon and for pip; what package.xml says is not said again."""

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
    package_data={name: ["py.typed", "page/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    install_requires=[
        "bdt_bags",
        "bdt_bringup",
        "bdt_msgs_py",
        "aiohttp>=3.9",
        "numpy>=1.26",
    ],
    zip_safe=False,
    entry_points={
        "bdt.benchmark": [
            "live = bdt_live.benchmark:live",
        ],
        "bdt.command": [
            "live = bdt_live.commands.live:COMMAND",
        ],
    },
)
