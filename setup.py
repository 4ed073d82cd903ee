"""What pyproject.toml cannot say: configs/ is packed as caricli/configs."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["caricli", "caricli.*"]), "caricli.configs"],
    package_dir={"caricli.configs": "configs"},
)
