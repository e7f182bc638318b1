// The hash as specified in mesh.proto: a client in another language, without code of this project,
// computes it from the bytes of GetSnapshot.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/source_path.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::hash_specification_test {
namespace {

class HashSpecification : public EndToEndTest {
 protected:
  // The snapshot's messages as they came, in gRPC's frames.
  void WriteSnapshot(const std::string& mesh, const std::string& path) {
    const auto stub = v1::MeshService::NewStub(
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
    grpc::ClientContext context;
    v1::GetSnapshotRequest request;
    request.set_mesh(mesh);
    const auto reader = stub->GetSnapshot(&context, request);
    std::ofstream out(path, std::ios::binary);
    for (v1::SnapshotChunk chunk; reader->Read(&chunk);) {
      const std::string bytes = chunk.SerializeAsString();
      const auto size = static_cast<std::uint32_t>(bytes.size());
      out.put(0);
      for (int shift = 24; shift >= 0; shift -= 8) out.put(static_cast<char>(size >> shift));
      out << bytes;
    }
    ASSERT_TRUE(reader->Finish().ok());
  }
  // Runs the script; returns its output, or "" if it fails.
  std::string Check(const std::string& files) const {
    const std::string printed = folder_.Path("printed");
    const std::string command = DYNMESH_PYTHON " -B " + test::SourcePath("tests/e2e/mesh_hash.py") +
                                " " + test::SourcePath("proto/dynmesh/v1/mesh.proto") + " " +
                                files + " > " + printed;
    if (std::system(command.c_str()) != 0) return "";
    return folder_.Read("printed");
  }

  test::TempFolder folder_;
};

std::vector<Feature> Square(FeatureId first, double lo, double hi) {
  return {Feature::Point(first, lo, lo), Feature::Point(first + 1, hi, lo),
          Feature::Point(first + 2, hi, hi), Feature::Point(first + 3, lo, hi),
          Feature::Polygon(first + 4, {{first, first + 1, first + 2, first + 3}})};
}

TEST_F(HashSpecification, IsEnoughForMeshesOfThePlane) {
  // Overlapping polygons, so that there are regions of several; a segment; sizes.
  std::vector<Feature> features = Square(1, 0.125, 0.5);
  for (const Feature& f : Square(11, 0.1875, 0.4375)) features.push_back(f);
  features.push_back(Feature::Point(21, 0.625, 0.125));
  features.push_back(Feature::Point(22, 0.875, 0.75));
  features.push_back(Feature::Segment(23, 21, 22));
  features.push_back(Feature::SizeDisc(24, 0.75, 0.5, 0.25, 0.01));
  ASSERT_TRUE(client_->Load("m", features).ok());
  WriteSnapshot("meshes/m", folder_.Path("plane"));
  const std::string printed = Check(folder_.Path("plane"));
  EXPECT_NE(printed.find("\n" + HeadOf().hash.ToHex() + " "), std::string::npos) << printed;
}

TEST_F(HashSpecification, IsEnoughForMeshesOfSpace) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = kDefaultQuality3D;
  ASSERT_TRUE(client_->CreateMesh("s", options).ok());
  // Two boxes with a common wall, one in one of them: three surfaces.
  std::vector<Feature> features;
  const auto add_box = [&](FeatureId first, double lo, double hi) {
    for (FeatureId k = 0; k < 8; ++k) {
      features.push_back(
          Feature::Point(first + k, k & 1 ? hi : lo, k & 2 ? hi : lo, k & 4 ? hi : lo));
    }
    const FeatureId faces[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                   {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
    for (FeatureId f = 0; f < 6; ++f) {
      std::vector<FeatureId> ring;
      for (const FeatureId corner : faces[f]) ring.push_back(first + corner);
      features.push_back(Feature::Polygon(first + 10 + f, {ring}));
    }
  };
  add_box(1, 0.25, 0.75);
  add_box(101, 0.375, 0.625);
  client::LoadParams params;
  params.dimension = 3;
  const auto loaded = client_->Load("s", features, params);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  WriteSnapshot("meshes/s", folder_.Path("space"));
  const std::string printed = Check(folder_.Path("space"));
  EXPECT_NE(printed.find("\n" + loaded->hash.ToHex() + " "), std::string::npos) << printed;
}

// A change of one bit of a coordinate, an owner or a region is detected.
TEST_F(HashSpecification, TheCheckFailsOfADamagedSnapshot) {
  ASSERT_TRUE(client_->Load("m", Square(1, 0.125, 0.5)).ok());
  WriteSnapshot("meshes/m", folder_.Path("whole"));
  ASSERT_NE(Check(folder_.Path("whole")), "");
  std::string bytes = folder_.Read("whole");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  folder_.Write("damaged", bytes);
  EXPECT_EQ(Check(folder_.Path("damaged") + " 2> " + folder_.Path("errors")), "");
}

}  // namespace
}  // namespace dynmesh::hash_specification_test
