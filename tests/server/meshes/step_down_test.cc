// A host whose journal has another owner, or does not know the outcome of an append.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "tests/server/meshes/edit_group_fixture.h"

namespace dynmesh::server {
namespace {

class StepDownTest : public EditGroupTest {
 protected:
  // After two batches that are refused with `reason`: readers see the last written revision, and
  // the host takes nothing any more, although the journal would.
  void ExpectDisowned(const std::shared_ptr<MeshHost>& host, const char* reason) {
    for (int i = 0; i < 2; ++i) EXPECT_EQ(ReasonOf(Next().status()), reason);
    EXPECT_TRUE(host->disowned());
    ExpectHead(*host, 1, {1});
    journal_.Answer(nullptr);
    const int appends = journal_.appends();
    Hand(*host, Job({AddPoint(4)}));
    EXPECT_EQ(ReasonOf(Next().status()), codec::reason::kNotOwner);
    Mailbox<absl::Status> located;
    ASSERT_TRUE(
        host->Locate({}, nullptr, [&](const auto& answer) { located.Put(answer.status()); }).ok());
    EXPECT_EQ(ReasonOf(located.Take()), codec::reason::kNotOwner);
    EXPECT_EQ(journal_.appends(), appends);
  }
};

TEST_F(StepDownTest, AFencedHostIsClosed) {
  const auto host = MakeHost();
  Hand(*host, Job({AddPoint(1)}));
  ASSERT_TRUE(Next().ok());
  EXPECT_FALSE(host->disowned());
  journal_.Answer([](int) { return absl::AbortedError("epoch 3 has the mesh"); });
  HandAll(*host, {Job({AddPoint(2)}), Job({AddPoint(3)})});
  ExpectDisowned(host, codec::reason::kNotOwner);
}

TEST_F(StepDownTest, AnUnknownOutcomeIsToldAsSuch) {
  const auto host = MakeHost();
  Hand(*host, Job({AddPoint(1)}));
  ASSERT_TRUE(Next().ok());
  journal_.Answer([](int) { return absl::UnknownError("the connection was lost"); });
  HandAll(*host, {Job({AddPoint(2)}, "a"), Job({AddPoint(3)}, "b")});
  ExpectDisowned(host, codec::reason::kOutcomeUnknown);
}

TEST_F(StepDownTest, ALargeBatchThatIsWrittenAloneIsUndone) {
  const auto host = MakeHost();
  Hand(*host, Job({AddPoint(1)}));
  ASSERT_TRUE(Next().ok());
  journal_.Answer([](int) { return absl::AbortedError("epoch 3 has the mesh"); });
  EditBatch many;
  for (FeatureId id = 2; id < 200; ++id) many.push_back(AddPoint(id));
  HandAll(*host, {Job(many), Job({AddPoint(1'000)})});
  ExpectDisowned(host, codec::reason::kNotOwner);
}

}  // namespace
}  // namespace dynmesh::server
