"""What a bag of rosbag2 looks like from outside: file names, first bytes, version."""

METADATA_FILE = "metadata.yaml"

NEWEST_VERSION = 9
"""Version of the metadata from ROS 2 Jazzy to Lyrical; the one that is written."""

MCAP_MAGIC = b"\x89MCAP0\r\n"
SQLITE_MAGIC = b"SQLite format 3\0"
"""First bytes of the files of both storages."""

SQLITE_PAGE_SIZES = tuple(512 << power for power in range(8))
"""Sizes that the pages of a sqlite3 file may have [bytes]."""

STORAGE_OF_SUFFIX = {".mcap": "mcap", ".db3": "sqlite3"}
"""Storages by the ends of the names of their files."""

COMPRESSED_SUFFIX = ".zstd"
"""What a compressed file's name has behind that."""
