"""Build file of bdt_bringup, for colcon and for pip."""

from setuptools import find_packages, setup

package_name = "bdt_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    package_data={package_name: ["py.typed", "pages/*.html", "pages/*.js"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="Backlash Digital Twin developers",
    maintainer_email="maintainers@backlash-digital-twin.invalid",
    description="Command bdt: runs the loop, records it and analyses the bag",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "bdt = bdt_bringup.cli:main",
            "recorder_node = bdt_bringup.running.recorder_node:main",
        ],
    },
)
