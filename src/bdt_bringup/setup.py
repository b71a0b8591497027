"""Build file of bdt_bringup, for colcon and for pip; what package.xml says is not said again."""

from pathlib import Path
from xml.etree import ElementTree as ET

from setuptools import find_packages, setup

package = ET.parse(Path(__file__).with_name("package.xml"))
name = package.findtext("name")
maintainer = package.find("maintainer")
# In the share folder, too, where users of ROS look: data_files wants paths from this folder on.
configurations = sorted(map(str, Path(name, "config").glob("*.yaml")))

setup(
    name=name,
    version=package.findtext("version"),
    description=package.findtext("description"),
    license=package.findtext("license"),
    maintainer=maintainer.text,
    maintainer_email=maintainer.get("email"),
    python_requires=">=3.11",
    packages=find_packages(),
    package_data={name: ["py.typed", "config/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (f"share/{name}/config", configurations),
    ],
    install_requires=[
        "bdt_msgs_py",
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "bdt = bdt_bringup.program:main",
            "controlled_driver = bdt_bringup.controlled_driver:main",
        ],
        "bdt.command": [
            "config = bdt_bringup.commands.config:COMMAND",
            "run = bdt_bringup.commands.run:COMMAND",
            "status = bdt_bringup.commands.status:COMMAND",
            "twins = bdt_bringup.commands.twins:COMMAND",
        ],
        "bdt.configurations": [
            "bdt_bringup = bdt_bringup",
        ],
    },
)
