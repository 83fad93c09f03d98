#include "nanoweft/record/snapshot_writer.hpp"

#include "nanoweft/base/log.hpp"
#include "nanoweft/record/segment_fields.hpp"
#include "nanoweft/record/snapshots.hpp"

namespace nanoweft {

namespace {

class SnapshotWriter : public Observer {
 public:
  SnapshotWriter(std::string name, long interval, const UnitSystem& units)
      : name_(std::move(name)), interval_(interval), units_(units) {}

  std::vector<Output> outputs() const override {
    return {{"snapshot_file", name_, Snapshots::makes}};
  }
  void check(const OutputContext& context) const override {
    Snapshots::check(context.comm, setting(context));
  }
  void claim(const OutputContext& context) override {
    restart_ = context.restart;
    snapshots_.emplace(context.comm, setting(context));
  }
  void open() override { snapshots_->begin(); }

  void begin(const Moment& moment) override {
    if (!restart_) write(moment);
  }
  View view(const Moment& moment) const override {
    return isDue(moment, interval_) ? View::motion : View::positions;
  }
  void observe(const Moment& moment) override {
    if (isDue(moment, interval_)) write(moment);
  }
  void summarise(const Moment&) const override { snapshots_->warnOfOthers(); }

 private:
  Snapshots::Setting setting(const OutputContext& context) const {
    return {name_, context.rule, context.rule.checkpoint, context.restart ? context.step : -1};
  }
  void write(const Moment& moment) {
    static const PetscLogEvent event = logEvent("NwFiles");
    const LogScope log(event);
    const System& s = moment.system;
    snapshots_->write(s.state, units_, moment.book.stageRecord(snapshotPurpose),
                      segmentFields(s.state, s.domain, s.forces));
  }

  std::string name_;
  long interval_;
  const UnitSystem& units_;
  bool restart_ = false;
  std::optional<Snapshots> snapshots_;
};

}  // namespace

std::unique_ptr<Observer> makeSnapshotWriter(const std::string& name, long interval,
                                             const UnitSystem& units) {
  if (name.empty()) return nullptr;
  return std::make_unique<SnapshotWriter>(name, interval, units);
}

}  // namespace nanoweft
