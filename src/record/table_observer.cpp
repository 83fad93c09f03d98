#include "nanoweft/record/table_observer.hpp"

#include <petscsys.h>

namespace nanoweft {

std::string timeColumn(const UnitSystem& units) {
  return std::string("time_") + units.time;
}

TableRun TableObserver::tableRun(const OutputContext& context) const {
  TableRun run;
  run.provenance = context.rule.run;
  run.checkpoint = context.rule.checkpoint;
  run.overwrite = context.rule.overwrite;
  run.restart = context.restart;
  run.interval = interval_;
  run.step = context.step;
  run.ends = context.over;
  return run;
}

std::vector<Observer::Output> TableObserver::outputs() const {
  return {{table_.option().c_str(), table_.fileName()}};
}

void TableObserver::check(const OutputContext& context) const {
  table_.check(context.comm, tableRun(context));
}

void TableObserver::claim(const OutputContext& context) {
  restart_ = context.restart;
  table_.claim(context.comm, tableRun(context));
}

void TableObserver::record(const Moment& moment) {
  if (wanted()) table_.record(moment.step(), row(moment));
}

void TableObserver::begin(const Moment& moment) {
  if (!table_.notice().empty())
    PetscPrintf(moment.state().comm(), "  %s\n", table_.notice().c_str());
  if (!restart_ || table_.isNew()) record(moment);
}

View TableObserver::view(const Moment& moment) const {
  return wanted() && isDue(moment, interval_) ? View::energies : View::positions;
}

void TableObserver::observe(const Moment& moment) {
  if (isDue(moment, interval_)) record(moment);
}

void TableObserver::finish(const Moment& moment) {
  record(moment);
}

}  // namespace nanoweft
