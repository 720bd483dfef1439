#include "gradus/io/patch_files.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "support/models.hpp"

using namespace gradus;

namespace {

/// A file that is gone at the end of the test.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::string& text = {}) {
        static std::mt19937 random(std::random_device{}());
        path_ =
            (std::filesystem::temp_directory_path() / ("gradus_patches_" + std::to_string(random()) + ".bpt")).string();
        std::ofstream(path_, std::ios::binary) << text;
    }
    ~TemporaryFile() { std::remove(path_.c_str()); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

PatchFile read_text(const std::string& text) { return read_patches(TemporaryFile(text).path()); }

void check_fault(const std::string& text, int line, const std::string& what) {
    CAPTURE(text);
    const TemporaryFile file(text);
    try {
        read_patches(file.path());
        FAIL("no IoError");
    } catch (const IoError& error) {
        CHECK(error.line() == line);
        CHECK(error.path() == file.path());
        CHECK_THAT(error.what(), Catch::StartsWith(file.path() + (line > 0 ? ":" + std::to_string(line) : "") + ": "));
        CHECK_THAT(error.what(), Catch::Contains(what));
    }
}

const std::string plane = "1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";

}  // namespace

TEST_CASE("The teapot comes back from its file", "[io][exact]") {
    const PatchFile file = read_patches(std::string(GRADUS_ASSETS) + "/teapot.bpt");
    CHECK(file.nets.size() == 32);
    CHECK_THAT(file.origin, Catch::Contains("Newell"));
    CHECK(file.nets[0].points[1] == Eigen::Vector3d(1.4, -0.784, 2.4));
    CHECK(make_model(file).num_components() == 4);
}

TEST_CASE("Patches written are read back to the bit", "[io][property]") {
    PatchFile file;
    file.origin = "first line\n\nthird line";
    file.nets = models::teapot_nets();
    for (const BezierNet& net : models::sphere_cube(1.0 / 3)) file.nets.push_back(net);
    for (const BezierNet& net : models::mixed_degrees()) file.nets.push_back(net);
    file.nets.push_back(models::scaled({models::bump(1e-300)}, 1e-9)[0]);
    const TemporaryFile target;
    write_patches(target.path(), file);
    const PatchFile back = read_patches(target.path());
    CHECK(back.origin == file.origin);
    REQUIRE(back.nets.size() == file.nets.size());
    for (std::size_t i = 0; i < file.nets.size(); ++i) {
        CHECK(back.nets[i].degree_u == file.nets[i].degree_u);
        CHECK(back.nets[i].degree_v == file.nets[i].degree_v);
        CHECK(back.nets[i].points == file.nets[i].points);
        CHECK(back.nets[i].weights == file.nets[i].weights);
    }
}

TEST_CASE("The usual layouts are told apart", "[io][exact]") {
    const PatchFile mixed = read_text("# a\n#b\r\n\n2 # count\r\n" + plane +
                                      "2 1\n0, 0, 0, 1\n1 0 0 .5\n2 0 0 1\n0 1 0 +1\n1 1 0 5e-1\n2 1 0 1");
    CHECK(mixed.origin == "a\nb\ncount");
    REQUIRE(mixed.nets.size() == 2);
    CHECK(mixed.nets[0].degree_u == 1);
    CHECK(mixed.nets[0].weights.empty());
    CHECK(mixed.nets[1].degree_u == 2);
    CHECK(mixed.nets[1].points[2] == Eigen::Vector3d(2, 0, 0));
    CHECK(mixed.nets[1].weights[1] == 0.5);

    const models::Nets teapot = models::teapot_nets();
    std::string bez = "32\n", rows = "32\n", vertices;
    int number = 0;
    for (const BezierNet& net : teapot) {
        for (std::size_t k = 0; k < 16; ++k) {
            char text[100];
            const Eigen::Vector3d& p = net.points[k];
            std::snprintf(text, sizeof text, "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
            bez += text;
            std::snprintf(text, sizeof text, "%.17g,%.17g,%.17g\n", p.x(), p.y(), p.z());
            vertices += text;
            rows += std::to_string(++number) + (k == 15 ? "\n" : ",");
        }
    }
    const PatchFile plain = read_text(bez), indexed = read_text(rows + "512\n" + vertices);
    for (std::size_t i = 0; i < 32; ++i) {
        CHECK(plain.nets[i].points == teapot[i].points);
        CHECK(indexed.nets[i].points == teapot[i].points);
    }
}

TEST_CASE("Malformed patch files are refused with their line", "[io]") {
    check_fault("", 0, "number of patches");
    check_fault("# only a comment\n", 1, "number of patches");
    check_fault("x\n", 1, "\"x\" is not the number of patches");
    check_fault("1 2 3\n", 1, "3 values");
    check_fault("0\n", 1, "must be 1 to");
    check_fault("-3\n", 1, "must be 1 to");
    check_fault("99999999999999\n", 1, "not the number of patches");
    check_fault("1\n", 1, "first patch should follow");
    check_fault("1\n1 1\n0 0 0\n1 0 0\n0 1 0\n", 5, "point 4 of 4 of patch 1");
    check_fault("2\n" + plane, 6, "patch 2 of 2");
    check_fault("1\n" + plane + "\n7\n", 8, "text after the last of 1 patches");
    check_fault("1\n0 1\n", 2, "a degree is 0, must be 1 to 25");
    check_fault("1\n3 26\n", 2, "a degree is 26");
    check_fault("1\n1.5 1\n", 2, "\"1.5\" is not a degree");
    check_fault("1\n1 1\n0 0 nan\n", 3, "not a finite number");
    check_fault("1\n1 1\n0 0 0\n0 inf 0\n", 4, "not a finite number");
    check_fault("1\n1 1\n0 0 1e999\n", 3, "not a number");
    check_fault("1\n1 1\n0 0 0x\n", 3, "\"0x\" is not a number");
    check_fault("1\n1 1\n0 0\n", 3, "2 values");
    check_fault("1\n1 1\n0 0 0 0\n", 3, "weight 0 is not positive");
    check_fault("1\n1 1\n0 0 0 1\n1 0 0\n", 4, "with and without weights");
    check_fault("1\n1 2 3 4 5\n", 2, "neither two degrees");
    const std::string row = "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16\n";
    check_fault("2\n" + row + "1,2,3\n", 3, "16 vertex numbers of patch 2");
    check_fault("1\n" + row, 2, "number of vertices");
    check_fault("1\n" + row + "3\n0,0,0\n0,0,0\n0,0,0\n", 2, "vertex 4 of 3");
    check_fault("1\n0" + row.substr(1) + "16\n", 2, "a vertex number is 0");
    check_fault("1\n" + row + "16\n0,0,0\n", 4, "vertex 2 of 16");
}

TEST_CASE("Missing files and unwritable places are IoErrors", "[io]") {
    CHECK_THROWS_AS(read_patches("/no/such/file.bpt"), IoError);
    CHECK_THROWS_WITH(read_patches("/no/such/file.bpt"),
                      "/no/such/file.bpt: cannot be opened: No such file or directory");
    CHECK_THROWS_AS(write_patches("/no/such/folder/file.bpt", {}), IoError);
    CHECK_THROWS_AS(read_patches(std::filesystem::temp_directory_path().string()), IoError);
}

TEST_CASE("A truncated teapot never passes", "[io][property]") {
    std::ifstream in(std::string(GRADUS_ASSETS) + "/teapot.bpt");
    const std::string whole((std::istreambuf_iterator<char>(in)), {});
    for (std::size_t size = 0; size + 4 < whole.size(); size += 97) {
        CAPTURE(size);
        CHECK_THROWS_AS(read_text(whole.substr(0, size)), IoError);
    }
}
