from conan import ConanFile
from conan.tools.cmake import CMake, cmake_layout
from conan.tools.files import copy


class Tribo(ConanFile):
    name = "tribo"
    version = "@VERSION@"
    description = "@DESCRIPTION@"
    license = "MIT"
    topics = ("control", "friction", "force", "embedded")
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeToolchain"
    exports_sources = "CMakeLists.txt", "LICENSE", "include/*", "src/*"
    package_type = "static-library"

    def layout(self):
        cmake_layout(self)

    def configure(self):
        self.settings.rm_safe("compiler.libcxx")
        self.settings.rm_safe("compiler.cppstd")

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, f"{self.package_folder}/licenses")
        copy(self, "*.h", f"{self.source_folder}/include", f"{self.package_folder}/include")
        copy(self, "*.a", self.build_folder, f"{self.package_folder}/lib", keep_path=False)

    def package_info(self):
        self.cpp_info.libs = ["tribo"]
        self.cpp_info.set_property("cmake_file_name", "tribo")
        self.cpp_info.set_property("cmake_target_name", "tribo::lib")
