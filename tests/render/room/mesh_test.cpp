#include "render/room/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "patient/package/package.h"
#include "tests/render/pictures.h"
#include "tests/render/refusal.h"
#include "tests/support/temp_folder.h"

namespace stylet::render {
namespace {

// One triangle as an embedded glTF. The buffer contains three positions, three normals, three 16-bit
// indices, three texture coordinates and three vertex colours.
constexpr char kTriangle[] = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"name":"piece","mesh":0,"translation":[1,2,3]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":3,"COLOR_0":4},
"indices":2,"mode":4,"material":0}]}],
"materials":[{"name":"paint","emissiveFactor":[0.5,0.25,0],
"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,1],"metallicFactor":0.5,"roughnessFactor":0.75}}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"},
{"bufferView":3,"componentType":5126,"count":3,"type":"VEC2"},
{"bufferView":4,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},
{"buffer":0,"byteOffset":72,"byteLength":6},{"buffer":0,"byteOffset":80,"byteLength":24},
{"buffer":0,"byteOffset":104,"byteLength":12}],
"buffers":[{"byteLength":116,"uri":"URI"}]})";

std::string base64(const std::vector<unsigned char>& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto at = [&](std::size_t k) { return k < bytes.size() ? unsigned(bytes[k]) : 0u; };
        const unsigned word = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
        text += kDigits[word >> 18];
        text += kDigits[(word >> 12) & 63];
        text += i + 1 < bytes.size() ? kDigits[(word >> 6) & 63] : '=';
        text += i + 2 < bytes.size() ? kDigits[word & 63] : '=';
    }
    return text;
}

std::vector<unsigned char> triangleBytes(std::uint16_t last_index = 2, float first = 0.0f,
                                         float first_uv = 0.0f) {
    const float floats[18] = {first, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const std::uint16_t indices[3] = {0, 1, last_index};
    const float uvs[6] = {first_uv, 0, 1, 0, 0, 1};
    const unsigned char colours[12] = {0, 0, 0, 255, 51, 51, 51, 255, 255, 255, 255, 255};
    std::vector<unsigned char> bytes(116, 0);
    std::memcpy(bytes.data(), floats, sizeof floats);
    std::memcpy(bytes.data() + 72, indices, sizeof indices);
    std::memcpy(bytes.data() + 80, uvs, sizeof uvs);
    std::memcpy(bytes.data() + 104, colours, sizeof colours);
    return bytes;
}

class MeshFile : public testing::Test {
  protected:
    static std::string triangle(const std::vector<unsigned char>& bytes = triangleBytes()) {
        return test::replaced(kTriangle, "URI", "data:application/octet-stream;base64," + base64(bytes));
    }
    Mesh load(const std::string& text) {
        const auto file = folder_ / "mesh.gltf";
        std::ofstream(file, std::ios::binary) << text;
        return loadMesh(file);
    }
    std::string refusal(const std::string& text) {
        return test::errorText([&] { load(text); });
    }
    test::TempFolder folder_;
};

std::string readAll(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST_F(MeshFile, ReadsATriangleThroughItsNode) {
    const Mesh mesh = load(triangle());
    ASSERT_EQ(mesh.vertices.size(), 3u);
    EXPECT_EQ(mesh.vertices[1].position_m, glm::vec3(2, 2, 3));
    EXPECT_EQ(mesh.vertices[1].normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(mesh.vertices[1].uv, glm::vec2(1, 0));
    EXPECT_EQ(mesh.vertices[0].open, 0.0f);
    EXPECT_FLOAT_EQ(mesh.vertices[1].open, 0.2f);
    EXPECT_EQ(mesh.vertices[2].open, 1.0f);
    EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2}));
    ASSERT_EQ(mesh.parts.size(), 1u);
    const MeshPart& part = mesh.parts.front();
    EXPECT_EQ(part.node, "piece");
    EXPECT_EQ(part.name, "paint");
    EXPECT_EQ(part.colour_linear, glm::vec3(1.0f, 0.5f, 0.25f));
    EXPECT_EQ(part.emission_linear, glm::vec3(0.5f, 0.25f, 0.0f));
    EXPECT_EQ(part.metallic, 0.5f);
    EXPECT_EQ(part.roughness, 0.75f);
}

TEST_F(MeshFile, TextureCoordinatesAndColoursMayBeAbsent) {
    const Mesh mesh = load(test::replaced(triangle(), R"(,"TEXCOORD_0":3,"COLOR_0":4)", ""));
    ASSERT_EQ(mesh.vertices.size(), 3u);
    EXPECT_EQ(mesh.vertices[1].uv, glm::vec2(0.0f));
    EXPECT_EQ(mesh.vertices[0].open, 1.0f);
}

// HZ-RECORD-14
TEST_F(MeshFile, InvalidFilesAreRejected) {
    const std::string good = triangle();
    EXPECT_EQ(refusal(good), "");
    struct InvalidMesh {
        const char *from, *to, *said;
    };
    for (const InvalidMesh& lie : {
             InvalidMesh{R"("count":3,"type":"VEC3"},)", R"("count":4,"type":"VEC3"},)",
                         "reaches past its view"},
             InvalidMesh{R"("count":3,"type":"VEC3"},)", R"("count":4000000000,"type":"VEC3"},)", "count"},
             InvalidMesh{R"("count":3,"type":"VEC3"},)", R"("count":0,"type":"VEC3"},)", "count"},
             InvalidMesh{R"("byteOffset":72,"byteLength":6)", R"("byteOffset":72,"byteLength":60)",
                         "past the buffer"},
             InvalidMesh{R"("byteOffset":36,)", R"("byteOffset":18446744073709551600,)", ""},
             InvalidMesh{R"("byteOffset":0,"byteLength":36)",
                         R"("byteOffset":0,"byteLength":36,"byteStride":4)", "stride"},
             InvalidMesh{R"("byteOffset":0,"byteLength":36)",
                         R"("byteOffset":0,"byteLength":36,"byteStride":100000)", ""},
             InvalidMesh{R"("POSITION":0)", R"("POSITION":7)", "no such accessor"},
             InvalidMesh{R"("POSITION":0)", R"("POSITION":2)", "wrong type"},
             InvalidMesh{R"("POSITION":0,)", "", "POSITION: missing"},
             InvalidMesh{R"("indices":2)", R"("indices":-1)", "indices"},
             InvalidMesh{R"("mode":4)", R"("mode":1)", "only triangles"},
             InvalidMesh{R"("bufferView":1)", R"("bufferView":9)", "no such buffer view"},
             InvalidMesh{R"("buffer":0,"byteOffset":36)", R"("buffer":3,"byteOffset":36)", ""},
             InvalidMesh{R"("componentType":5123)", R"("componentType":5121)", "16 nor 32"},
             InvalidMesh{R"("componentType":5126)", R"("componentType":1)", ""},
             InvalidMesh{R"("nodes":[0])", R"("nodes":[5])", "no such node"},
             InvalidMesh{R"("mesh":0,)", R"("mesh":3,)", "no such mesh"},
             InvalidMesh{R"("mesh":0,)", R"("mesh":0,"children":[0],)", "reached twice"},
             InvalidMesh{R"("nodes":[0])", R"("nodes":[0,0])", "reached twice"},
             InvalidMesh{R"("translation":[1,2,3])", R"("translation":[1,2])", "wrong length"},
             InvalidMesh{R"("scenes":[{"nodes":[0]}])", R"("scenes":[])", ""},
             InvalidMesh{R"("material":0)", R"("material":2)", "no such material"},
             InvalidMesh{R"("TEXCOORD_0":3)", R"("TEXCOORD_0":0)", "TEXCOORD_0: of the wrong type"},
             InvalidMesh{R"("TEXCOORD_0":3)", R"("TEXCOORD_0":31)", "no such accessor"},
             InvalidMesh{R"("count":3,"type":"VEC2")", R"("count":2,"type":"VEC2")", "not one for each"},
             InvalidMesh{R"("count":3,"type":"VEC2")", R"("count":4,"type":"VEC2")", "reaches past its view"},
             InvalidMesh{R"("COLOR_0":4)", R"("COLOR_0":1)", "COLOR_0: of the wrong type"},
             InvalidMesh{R"("componentType":5121)", R"("componentType":5123)", "COLOR_0"},
             InvalidMesh{R"("count":3,"type":"VEC4")", R"("count":1,"type":"VEC4")", "not one for each"},
             InvalidMesh{R"("byteOffset":104,"byteLength":12)", R"("byteOffset":104,"byteLength":13)",
                         "past the buffer"},
             InvalidMesh{R"("metallicFactor":0.5)", R"("metallicFactor":-0.5)", "metallicFactor"},
             InvalidMesh{R"("roughnessFactor":0.75)", R"("roughnessFactor":1e40)", "roughnessFactor"},
             InvalidMesh{R"("emissiveFactor":[0.5,0.25,0])", R"("emissiveFactor":[0.5,0.25,7])",
                         "emissiveFactor"},
             InvalidMesh{R"("baseColorFactor":[1,0.5,0.25,1])", R"("baseColorFactor":[1,-1,0.25,1])",
                         "baseColorFactor"},
             InvalidMesh{R"("version":"2.0")", R"("ver":"2.0")", ""},
         }) {
        const std::string said = refusal(test::replaced(good, lie.from, lie.to));
        EXPECT_FALSE(said.empty()) << lie.to;
        EXPECT_NE(said.find(lie.said), std::string::npos) << lie.to << " -> " << said;
        EXPECT_NE(said.find("mesh.gltf"), std::string::npos) << said;
    }
    EXPECT_NE(refusal(triangle(triangleBytes(3))).find("names vertex 3 of 3"), std::string::npos);
    EXPECT_NE(refusal(triangle(triangleBytes(2, std::nanf("")))).find("not finite"), std::string::npos);
    EXPECT_NE(refusal(triangle(triangleBytes(2, 0.0f, INFINITY))).find("TEXCOORD_0"), std::string::npos);
    EXPECT_NE(refusal(test::replaced(kTriangle, "URI", "data:application/octet-stream;base64,AAAA")), "");
    EXPECT_NE(refusal(""), "");
    EXPECT_NE(refusal("{"), "");
    EXPECT_THROW(loadMesh(folder_ / "absent.glb"), DataError);
}

// HZ-RECORD-14
TEST_F(MeshFile, ExternalBuffersAreNotRead) {
    std::ofstream(folder_ / "beside.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(triangleBytes().data()), 116);
    for (const std::string& uri : {std::string("beside.bin"), std::string("../beside.bin"),
                                   (folder_ / "beside.bin").string(), std::string("/etc/hostname")})
        EXPECT_NE(refusal(test::replaced(kTriangle, "URI", uri)), "") << uri;
}

// A truncated or damaged file is either read or rejected with a DataError.
TEST_F(MeshFile, DamagedShippedFilesAreReadOrRejected) {
    const std::string good = readAll(test::assetsFolder() / "instruments" / "needle.glb");
    std::mt19937 random(11);
    int refused = 0;
    for (int i = 0; i < 150; ++i) {
        std::string bad = good;
        if (i % 3 == 0)
            bad.resize(random() % good.size());
        else if (i % 3 == 1)
            bad[random() % 2500] = char(random());  // the header and the JSON
        else
            bad += std::string(1 + random() % 9, char(random()));
        const std::string said = refusal(bad);
        refused += said.empty() ? 0 : 1;
        if (i % 3 != 1) {
            EXPECT_NE(said, "") << i;
        }
    }
    EXPECT_GT(refused, 100);
}

// The renderer scales these parts to a needle. They have radius 1 and length 1, and a tip has its point at
// the origin.
TEST(Assets, PartsOfTheNeedleAreOfUnitSize) {
    const Mesh mesh = loadMesh(test::assetsFolder() / "instruments" / "needle.glb");
    for (const char* node : {"shaft", "tip_chiba", "tip_trocar", "tip_diamond"}) {
        float lowest = 1.0f, highest = 0.0f, widest = 0.0f;
        glm::vec3 tip(1.0f);
        for (const MeshPart& part : mesh.parts) {
            if (part.node != node) continue;
            for (std::uint32_t i = 0; i < part.index_count; ++i) {
                const glm::vec3 p = mesh.vertices[mesh.indices[part.first_index + i]].position_m;
                if (p.z < lowest) lowest = p.z, tip = p;
                highest = std::max(highest, p.z);
                widest = std::max(widest, std::hypot(p.x, p.y));
            }
        }
        EXPECT_NEAR(lowest, 0.0f, 1e-6f) << node;
        EXPECT_NEAR(highest, 1.0f, 1e-6f) << node;
        EXPECT_NEAR(widest, 1.0f, 1e-5f) << node;
        if (std::string(node) != "shaft") {
            EXPECT_NEAR(std::hypot(tip.x, tip.y), 0.0f, 1e-4f) << node;
        }
    }
}

// The lens of each probe is nearly as long as the face that is felt, 60 and 40 mm, and bent as it is.
TEST(Assets, ProbesHaveTheirFaces) {
    const Mesh mesh = loadMesh(test::assetsFolder() / "instruments" / "probe.glb");
    for (const auto& [node, length_m, depth_m] :
         {std::tuple{"probe", 0.060f, 0.0080f}, {"linear_probe", 0.040f, 0.0f}}) {
        float far_x = 0.0f, back = 1.0f;
        for (const MeshPart& part : mesh.parts)
            for (std::uint32_t i = 0; part.node == node && part.name == "lens" && i < part.index_count; ++i) {
                const glm::vec3 p = mesh.vertices[mesh.indices[part.first_index + i]].position_m;
                if (p.x > far_x + 1e-5f) far_x = p.x, back = 1.0f;
                if (p.x > far_x - 1e-5f) back = std::min(back, p.z);
            }
        EXPECT_NEAR(2.0f * far_x, length_m, 0.004f) << node;
        EXPECT_NEAR(back, depth_m, 0.0015f) << node;
    }
}

TEST(Assets, NormalsAreUnitAndTrianglesFaceOutwards) {
    for (const char* name :
         {"rooms/table_top.glb", "rooms/table_pedestal.glb", "rooms/c_arm.glb", "rooms/ultrasound.glb",
          "rooms/xray_monitor.glb", "rooms/patient_monitor.glb", "rooms/trolley.glb", "rooms/lamp.glb",
          "rooms/room.glb", "rooms/built_in.glb", "instruments/needle.glb", "instruments/probe.glb",
          "instruments/scalpel.glb", "instruments/hand.glb"}) {
        const Mesh mesh = loadMesh(test::assetsFolder() / name);
        std::size_t against = 0;
        EXPECT_LT(std::filesystem::file_size(test::assetsFolder() / name), 150u * 1024u) << name;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const Vertex &a = mesh.vertices[mesh.indices[i]], &b = mesh.vertices[mesh.indices[i + 1]],
                         &c = mesh.vertices[mesh.indices[i + 2]];
            EXPECT_NEAR(glm::length(a.normal), 1.0f, 1e-4f) << name;
            const glm::vec3 face = glm::cross(b.position_m - a.position_m, c.position_m - a.position_m);
            if (glm::dot(face, a.normal + b.normal + c.normal) < 0.0f) ++against;
        }
        EXPECT_EQ(against, 0u) << name;
    }
}

// Volume inside a closed mesh, by the divergence theorem. Positive if its triangles face outwards.
double volumeOf(const Mesh& mesh) {
    double volume = 0.0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const auto at = [&](std::size_t k) {
            return glm::dvec3(mesh.vertices[mesh.indices[i + k]].position_m);
        };
        volume += glm::dot(at(0), glm::cross(at(1), at(2))) / 6.0;
    }
    return volume;
}

// Closed forms: of a prism and a pyramid over a regular polygon, and of a torus.
TEST(UnitMeshes, AreClosedAndHaveTheirVolumes) {
    const double pi = 3.141592653589793, polygon = 0.5 * 12 * std::sin(2.0 * pi / 12);
    EXPECT_NEAR(volumeOf(unitTube(12)), polygon, 1e-6);
    EXPECT_NEAR(volumeOf(unitCone(12)), polygon / 3.0, 1e-6);
    EXPECT_NEAR(volumeOf(unitRing(400, 200, 0.1f)), 2.0 * pi * pi * 0.01, 1e-4);
    for (const Mesh& mesh : {unitTube(12), unitCone(12), unitRing(40, 12, 0.09f)})
        for (const Vertex& v : mesh.vertices)
            EXPECT_NEAR(glm::length(v.normal), 1.0f, 1e-5f);
}

}  // namespace
}  // namespace stylet::render
