#include "nanoweft/app/observers.hpp"

namespace nanoweft {

namespace {

/// What may be said against a state file as an output.
void checkStateTarget(const std::string& file, const OutputContext& context) {
  makeParentFolder(context.comm, file);
  refuseForeignTarget(context.comm, file, context.rule);
  requireWritable(context.comm, file);
}

class Checkpoints : public Observer {
 public:
  explicit Checkpoints(const ObserverContext& context)
      : file_(context.settings.checkpointFile), interval_(context.settings.checkpointInterval) {}

  std::vector<Output> outputs() const override { return {{"checkpoint_file", file_}}; }
  void check(const OutputContext& context) const override { checkStateTarget(file_, context); }
  View view(const Moment& moment) const override {
    return isDue(moment, interval_) ? View::motion : View::positions;
  }
  void observe(const Moment& moment) override {
    if (isDue(moment, interval_)) moment.book.writeCheckpoint(file_);
  }
  void finish(const Moment& moment) override {
    if (moment.book.lastCheckpoint() != moment.step()) moment.book.writeCheckpoint(file_);
  }

 private:
  std::string file_;
  long interval_;
};

class FinalState : public Observer {
 public:
  explicit FinalState(const ObserverContext& context)
      : file_(context.settings.stateOutput),
        forces_(context.settings.stateForces),
        units_(context.units) {}

  std::vector<Output> outputs() const override { return {{"state_output", file_}}; }
  void check(const OutputContext& context) const override { checkStateTarget(file_, context); }
  void finish(const Moment& moment) override {
    StateWriteOptions what;
    what.forces = forces_;
    writeState(file_, moment.system.state, units_, moment.book.fullRecord(finalPurpose), what);
  }

 private:
  std::string file_;
  bool forces_;
  const UnitSystem& units_;
};

}  // namespace

std::unique_ptr<Observer> makeCheckpoints(const ObserverContext& context) {
  if (context.settings.checkpointFile.empty()) return nullptr;
  return std::make_unique<Checkpoints>(context);
}

std::unique_ptr<Observer> makeFinalState(const ObserverContext& context) {
  if (context.settings.stateOutput.empty()) return nullptr;
  return std::make_unique<FinalState>(context);
}

}  // namespace nanoweft
