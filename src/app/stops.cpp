#include "nanoweft/app/observers.hpp"
#include "nanoweft/app/signals.hpp"
#include "nanoweft/app/wall_time.hpp"

namespace nanoweft {

namespace {

/// Stops the run when its wish has been heard.
class Stop : public Observer {
 public:
  void hear() override { heard_ = true; }
  View view(const Moment&) const override { return heard_ ? View::motion : View::positions; }
  Verdict verdict(const Moment&) const override { return heard_ ? Verdict::stop : Verdict::goOn; }
  std::string reason() const override { return heard_ ? cause() : ""; }

 protected:
  virtual std::string cause() const = 0;

 private:
  bool heard_ = false;
};

class SignalStop : public Stop {
 public:
  bool wishes(const Moment&) override { return stopRequested(); }

 protected:
  std::string cause() const override { return "stopped by a signal"; }
};

class WallTimeStop : public Stop {
 public:
  explicit WallTimeStop(double limit) : limit_(limit) {}

  bool wishes(const Moment& moment) override {
    if (moment.state().rank() != 0) return false;
    return limit_.over(secondsSinceStart(), moment.book.checkpointSeconds());
  }

 protected:
  std::string cause() const override {
    return "stopped: the wall time of " + shownDuration(limit_.limit()) + " is over";
  }

 private:
  WallLimit limit_;
};

}  // namespace

std::unique_ptr<Observer> makeSignalStop(const ObserverContext&) {
  return std::make_unique<SignalStop>();
}

std::unique_ptr<Observer> makeWallTimeStop(const ObserverContext& context) {
  if (!context.settings.wallTime) return nullptr;
  return std::make_unique<WallTimeStop>(*context.settings.wallTime);
}

}  // namespace nanoweft
