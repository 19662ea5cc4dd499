"""`conan create .`: the library alone, with its networks. Exported and inspected here; never built, since no server of packages is
reached from where the project is made."""

import os

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import load


class Diffsac(ConanFile):
    name = "diffsac"
    description = "Robust estimation of lines, planes, homographies, fundamental and essential matrices, poses and motions"
    license = "MIT"
    topics = ("ransac", "robust-estimation", "computer-vision")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False]}
    default_options = {"shared": False}
    exports = "lib/diffsac/core/version.h"
    exports_sources = "CMakeLists.txt", "cmake/*", "lib/CMakeLists.txt", "lib/diffsac/*", "models/*", "configs/*", "docs/*", "*.md", \
        "scripts/report/*", "data_tools/*", "benchmarks/README.md", "CITATION.cff", "LICENSE"
    generators = "CMakeDeps"

    def set_version(self):
        self.version = load(self, os.path.join(self.recipe_folder, "lib/diffsac/core/version.h")).split('kVersion[] = "')[1].split('"')[0]

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        self.requires("onetbb/2021.12.0")
        for headers in ("boost/1.83.0", "nanoflann/1.5.2", "nlohmann_json/3.11.3"):
            self.requires(headers, visible=False)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update(DIFFSAC_LAB=False, BUILD_SHARED_LIBS=bool(self.options.shared))
        toolchain.generate()

    def build(self):
        CMake(self).configure()
        CMake(self).build()

    def package(self):
        CMake(self).install(component="library")

    def package_info(self):
        # diffsacConfig.cmake as it was installed.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "diffsac")]
