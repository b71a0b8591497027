"""What provides the packages that are imported: a distribution for pip, a key for rosdep.

The keys are those of ``rosdep/python.yaml`` and, for ROS packages, of the distribution jazzy. Some
packages have no key of their own and come along with one that has.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Provider:
    """What provides an imported package.

    Attributes
    ----------
    distribution : str or None
        Its distribution on an index; None for what ROS 2 alone has.
    rosdep_key : str or None
        The key that installs it beside ROS 2; None where there is none.
    """

    distribution: str | None
    rosdep_key: str | None


_ROSBAGS = "python3-rosbags-pip"
_MCAP = "mcap-ros2-support"

PROVIDERS = {
    "aiohttp": Provider("aiohttp", "python3-aiohttp"),
    "control": Provider("control", "python-control-pip"),
    "jinja2": Provider("jinja2", "python3-jinja2"),
    "matplotlib": Provider("matplotlib", "python3-matplotlib"),
    "numba": Provider("numba", "python3-numba"),
    "numpy": Provider("numpy", "python3-numpy"),
    "rich": Provider("rich", "python3-rich"),
    "rosbags": Provider("rosbags", _ROSBAGS),
    "ruamel": Provider("ruamel.yaml", "python3-ruamel.yaml"),
    "scipy": Provider("scipy", "python3-scipy"),
    "serial": Provider("pyserial", "python3-serial"),
    "yaml": Provider("pyyaml", "python3-yaml"),
    # No keys of their own: rosbags requires the first three, mcap the last one, and pip installs
    # mcap with the one key that needs it.
    "apsw": Provider("apsw", _ROSBAGS),
    "backports": Provider("backports.zstd", _ROSBAGS),
    "lz4": Provider("lz4", _ROSBAGS),
    "mcap": Provider("mcap", _MCAP),
    "zstandard": Provider("zstandard", _MCAP),
    # No keys at all; the reasons in `WITHOUT_ROSDEP` say what is missing without them.
    "cyclonedds": Provider("cyclonedds", None),
    "distributed": Provider("distributed", None),
    "plotly": Provider("plotly", None),
    "pyarrow": Provider("pyarrow", None),
    "SALib": Provider("salib", None),
    # On no index: ROS 2 has them, or embedded_ros, which is never installed beside ROS 2.
    **{
        name: Provider(None, name)
        for name in (
            "builtin_interfaces",
            "diagnostic_msgs",
            "rcl_interfaces",
            "rclpy",
            "rosgraph_msgs",
            "sensor_msgs",
            "std_msgs",
            "std_srvs",
        )
    },
}
"""Providers of packages of others, by the name that is imported."""

WITHOUT_ROSDEP = {
    ("bdt_analysis", "plotly"): "pages show pictures alone",
    ("bdt_analysis", "pyarrow"): "--export parquet is refused; the extra `parquet` for pip",
    ("bdt_study", "distributed"): "--scheduler is refused; the extra `sweep` for pip",
    ("bdt_study", "pyarrow"): "data sets are refused; the extra `sweep` for pip",
    ("bdt_study", "SALib"): "bdt sweep report is refused; the extra `sweep` for pip",
}
"""What package.xml cannot name for want of a key: package, import, and what is without it."""

UNDECLARED = {
    ("bdt_study", "cyclonedds"): "the floor of a benchmark, skipped where embedded_ros is not",
}
"""What is looked for and declared nowhere: package, import, and why."""
