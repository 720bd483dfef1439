// Files that are damaged, or made to do harm.
#include <catch2/catch.hpp>

#include "gradus/io/mesh_files.hpp"
#include "support/damage.hpp"
#include "support/hostile_file.hpp"
#include "support/memory_limit.hpp"
#include "support/valid_files.hpp"
#include "support/vtk_files.hpp"

using namespace gradus;
using support::TemporaryFolder;

namespace {

constexpr std::size_t kMostMemory = std::size_t{2} << 30;  // files here are of some kB, or promise more than this

}  // namespace

TEST_CASE("valid files of every format are read, repaired and made surfaces of", "[io]") {
    const TemporaryFolder folder;
    for (const auto& files : {support::valid_mesh_files(), support::valid_size_files()})
        for (const auto& [extension, contents] : files) {
            INFO(extension << "\n" << contents);
            support::spill(folder / ("a" + extension), contents);
            const support::Attempt attempt = support::read_and_use(folder / ("a" + extension));
            CHECK_FALSE(attempt.refused);
            CHECK(attempt.fault == "");
        }
}

TEST_CASE("10 000 damaged files are refused in a line or read soundly", "[io][property]") {
    constexpr int kFiles = 10000;
    const TemporaryFolder folder;
    std::vector<support::ValidFile> files = support::valid_mesh_files();
    for (support::ValidFile& file : support::valid_size_files()) files.push_back(std::move(file));
    std::mt19937_64 random(11);
    const support::MemoryLimit limit(kMostMemory);
    int refused = 0;
    for (int k = 0; k < kFiles; ++k) {
        const auto& [extension, valid] = files[static_cast<std::size_t>(k) % files.size()];
        const std::string contents = support::damaged(valid, random);
        support::spill(folder / ("a" + extension), contents);
        const support::Attempt attempt = support::read_and_use(folder / ("a" + extension));
        refused += attempt.refused;
        if (attempt.fault.empty()) continue;
        INFO(extension << "\n" << contents);
        FAIL_CHECK(attempt.fault);
    }
    CHECK(refused > kFiles / 4);
    CHECK(refused < kFiles * 9 / 10);
}

TEST_CASE("headers that promise more than the file holds are refused before memory is taken", "[io]") {
    constexpr const char* kMany = "1000000000";
    const std::string n(kMany), msh = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
                                medit = "MeshVersionFormatted 2\nDimension 3\n";
    std::string stl(80, ' '), meshb, msh_binary = "$MeshFormat\n4.1 1 8\n", sizes;
    support::put(stl, std::uint32_t{1000000000});
    for (const std::int32_t word : {1, 2, 4, 1 << 30, 1000000000}) support::put(meshb, word);
    for (const std::int32_t word : {1, 2, 62, 1 << 30, 1000000000}) support::put(sizes, word);
    support::put(msh_binary, std::int32_t{1});
    msh_binary += "\n$EndMeshFormat\n$Nodes\n";
    for (const std::uint64_t word : {1, 1000000000, 1, 1000000000}) support::put(msh_binary, word);
    const auto vtu = [&](const std::string& points, const std::string& data) {
        return "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"" + points +
               "\" NumberOfCells=\"" + n + "\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" " + data +
               "</DataArray></Points></Piece></UnstructuredGrid></VTKFile>\n";
    };
    std::string long_array;
    support::put(long_array, std::uint32_t{3000000000});
    const support::ValidFile files[] = {
        {".off", "OFF\n" + n + " 1 0\n0 0 0\n"},
        {".off", "OFF\n3 " + n + " 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {".off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n" + n + " 0 1 2\n"},
        {".ply", "ply\nformat ascii 1.0\nelement vertex " + n +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face 0\n"
                     "property list uchar int vertex_indices\nend_header\n"},
        {".ply",
         "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float "
         "z\n"
         "element face 1\nproperty list uint int vertex_indices\nend_header\n\xff\xff\xff\x7f"},
        {".stl", stl + std::string(50, '\0')},
        {".mesh", medit + "Vertices\n" + n + "\n0 0 0 0\n"},
        {".mesh", medit + "Vertices\n1\n0 0 0 0\nTriangles\n" + n + "\n1 1 1 0\n"},
        {".meshb", meshb},
        {".msh", msh + "$Nodes\n1 " + n + " 1 " + n + "\n2 1 0 " + n + "\n1\n0 0 0\n$EndNodes\n"},
        {".msh", msh_binary},
        {".vtu", vtu(n, "format=\"ascii\">0 0 0")},
        {".vtu", vtu("1", "format=\"binary\">" + support::vtk::base64(long_array))},
        {".sol", medit + "SolAtVertices\n" + n + "\n1 1\n1\n"},
        {".solb", sizes},
    };
    const TemporaryFolder folder;
    const support::MemoryLimit limit(kMostMemory);
    for (const auto& [extension, contents] : files) {
        INFO(extension << "\n" << contents);
        support::spill(folder / ("a" + extension), contents);
        const support::Attempt attempt = support::read_and_use(folder / ("a" + extension));
        CHECK(attempt.refused);
        CHECK(attempt.fault == "");
    }
}

TEST_CASE("small files that multiply their fields are refused before memory is taken", "[io][regression]") {
    constexpr int kMany = 20000;
    std::string corners, nodes, properties, values, sections, arrays;
    for (int i = 0; i < kMany; ++i) {
        corners += std::to_string(i % 3) + " ";
        nodes += std::to_string(i + 1) + " 0 0 " + std::to_string(i) + "\n";
    }
    for (int i = 0; i < 2000; ++i) {
        properties += "property uchar p" + std::to_string(i) + "\n";
        values += " 1";
    }
    for (int i = 0; i < 1000; ++i) {
        sections += "$NodeData\n1\n\"" + std::to_string(i) + "\"\n0\n3\n0\n9\n0\n$EndNodeData\n";
        arrays += "<DataArray type=\"UInt8\" Name=\"" + std::to_string(i) +
                  "\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>";
    }
    const std::string points = "0 0 0\n1 0 0\n0 1 0\n", end = "</Piece></UnstructuredGrid>";
    const auto vtu = [&](const std::string& num_points, const std::string& num_cells, const std::string& rest) {
        return "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"" + num_points +
               "\" NumberOfCells=\"" + num_cells + "\">" + rest;
    };
    std::string appended;
    support::put(appended, std::uint32_t{210000});
    appended += std::string(210000, 'x');
    const support::ValidFile files[] = {
        {".ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
         "1\n"
         "property list int int vertex_indices\n" +
             properties + "end_header\n" + points + std::to_string(kMany) + " " + corners + values},
        {".msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(kMany) + "\n" + nodes +
                     "$EndNodes\n$Elements\n1\n1 2 0 1 2 3\n$EndElements\n" + sections},
        {".vtu", vtu("3", "1",
                     "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">" + points +
                         "</DataArray></Points><Cells>"
                         "<DataArray type=\"Int32\" Name=\"connectivity\">" +
                         corners + "</DataArray><DataArray type=\"Int32\" Name=\"offsets\">" + std::to_string(kMany) +
                         "</DataArray><DataArray type=\"UInt8\" Name=\"types\">7</DataArray></Cells>"
                         "<CellData><DataArray type=\"UInt8\" Name=\"c\" NumberOfComponents=\"2000\">" +
                         values + "</DataArray></CellData>" + end + "</VTKFile>")},
        {".vtu", vtu("70000", "0",
                     "<Points><DataArray type=\"UInt8\" NumberOfComponents=\"3\" format=\"appended\" "
                     "offset=\"0\"/></Points><PointData>" +
                         arrays + "</PointData>" + end + "<AppendedData encoding=\"raw\">_" + appended +
                         "</AppendedData></VTKFile>")},
    };
    const TemporaryFolder folder;
    const support::MemoryLimit limit(kMostMemory);
    for (const auto& [extension, contents] : files)
        support::check_refused(folder / ("a" + extension), contents, 0, "beyond what a file of its size means",
                               [](const std::string& path) { read_mesh_data(path); });
}
