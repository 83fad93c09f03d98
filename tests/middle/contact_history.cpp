/// What friction remembers of contacts that roll along their fibres.
#include "nanoweft/force/contact_history.hpp"

#include "middle/segments.hpp"

namespace nanoweft::test {
namespace {

class ContactHistoryTest : public testing::Test {
 protected:
  ContactHistoryTest() {
    // Each rank has all segments for itself.
    state.addOwned(allRows);
    for (int i = 0; i < allRows; ++i) {
      setSegment(state, i, i);
      std::fill_n(state.contact + contactSlots * i, contactSlots, 0);
      std::fill_n(state.spring + 3 * contactSlots * i, 3 * contactSlots, 0.0);
      state.bond[i] &= ~nextBroken;
    }
    state.countTotal();
    state.noteFreeEnds();
    domain.rebuild(state, 15, 15, nullptr);
    history.rebuild(state, domain);
  }
  int at(std::int64_t row) { return domain.localIndex(row); }
  Share all() const { return {0, static_cast<int>(allRows)}; }
  void setSpring(std::int64_t row, std::int64_t partner, const Vec3d& v) {
    double* const spring = history.find(state, at(row), partner).at;
    ASSERT_TRUE(spring);
    spring[0] = v.x, spring[1] = v.y, spring[2] = v.z;
  }
  /// What the contact of two segments takes over when that of two others has been there before.
  Vec3d inherited(std::int64_t row, std::int64_t partner, std::int64_t before,
                  std::int64_t beforePartner) {
    history.begin(all());
    setSpring(before, beforePartner, {1, 2, 3});
    setSpring(beforePartner, before, {1, 2, 3});
    history.end(state, all());
    history.begin(all());
    for (const auto& [a, b] : {std::pair{before, beforePartner}, {row, partner}}) {
      history.find(state, at(a), b);
      history.find(state, at(b), a);
    }
    history.end(state, all());
    Vec3d sum;
    int count = 0;
    for (const auto& heir : history.heirs(state, all())) sum += heir.spring, ++count;
    EXPECT_TRUE(count == 0 || count == 2) << count;  // both of the two segments, or none
    return count ? (1.0 / count) * sum : Vec3d{};
  }

  State state{PETSC_COMM_SELF, sceneBox(), allFields};
  Domain domain{state, {PartitionSettings::rectilinear, 1.05, 4}};
  ContactHistory history;
};

void expectVector(const Vec3d& found, const Vec3d& expected) {
  EXPECT_LT(norm(found - expected), 1e-15) << found.x << " " << found.y << " " << found.z;
}

constexpr std::int64_t closed = firstClosed, open = 0, far = 20;  // rows; `far`: of another fibre

TEST_F(ContactHistoryTest, PassesSpringsToTheNextSegment) {
  expectVector(inherited(open + 4, far, open + 3, far), {1, 2, 3});
}

TEST_F(ContactHistoryTest, PassesThemWithTheOtherSignWhereTheOrderOfBothTurns) {
  // A closed fibre's last segment (39) is beyond 36 of the fibre itself, its first one (32) before.
  expectVector(inherited(closed, closed + 4, closed + 7, closed + 4), {-1, -2, -3});
}

TEST_F(ContactHistoryTest, DoesNotPassThemOverFreeEndsAndToStrangers) {
  expectVector(inherited(open, far, open + 7, far), {0, 0, 0});
  expectVector(inherited(open + 6, far, open + 3, far), {0, 0, 0});
}

TEST_F(ContactHistoryTest, SaysThatASegmentHasTooManyContacts) {
  history.begin(all());
  for (int k = 0; k < contactSlots; ++k) EXPECT_TRUE(history.find(state, at(1), 20 + k).at);
  EXPECT_FALSE(history.full());
  EXPECT_FALSE(history.find(state, at(1), 20 + contactSlots).at);
  EXPECT_TRUE(history.full());
}

TEST_F(ContactHistoryTest, ForgetsWhatIsNotFoundAgain) {
  history.begin(all());
  setSpring(1, far, {1, 2, 3});
  history.end(state, all());
  history.begin(all());
  history.end(state, all());
  history.begin(all());
  const auto spring = history.find(state, at(1), far);
  EXPECT_TRUE(spring.fresh);
  EXPECT_EQ(spring.at[0], 0);
}

}  // namespace
}  // namespace nanoweft::test
