"""Build file of bdt_analysis, for colcon and for pip; what package.xml says is not said again."""

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
    package_data={name: ["py.typed", "pages/*.html", "pages/*.js"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    install_requires=[
        "bdt_bags",
        "bdt_msgs_py",
        "bdt_plant",
        "bdt_twin",
        "jinja2>=3.1",
        "matplotlib>=3.6",
        "numpy>=1.26",
        "plotly>=5",
        "pyyaml>=6",
        "rich>=13",
    ],
    extras_require={"parquet": ["pyarrow>=14"]},
    zip_safe=False,
    entry_points={
        "bdt.command": [
            "analyze = bdt_analysis.commands.analyze:COMMAND",
            "compare = bdt_analysis.commands.compare:COMMAND",
        ],
    },
)
