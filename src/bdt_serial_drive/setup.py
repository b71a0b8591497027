"""Build file of bdt_serial_drive, for colcon and pip; what package.xml says is not repeated."""

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
        "bdt_driver",
        "numpy",
        "pyserial",
    ],
    zip_safe=False,
)
