/// What all observers that record a table have in common.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "nanoweft/record/observer.hpp"
#include "nanoweft/record/table_monitor.hpp"

namespace nanoweft {

/// A table with a row every `interval` steps, one for the first and one for the last state. Derived
/// classes say what is in a row.
class TableObserver : public Observer {
 public:
  TableObserver(Options& options, TableMonitor::Layout layout, long interval)
      : table_(options, std::move(layout)), interval_(interval) {}

  bool wanted() const { return table_.wanted(); }

  std::vector<Output> outputs() const override;
  void check(const OutputContext& context) const override;
  void claim(const OutputContext& context) override;
  void open() override { table_.open(); }
  void begin(const Moment& moment) override;
  View view(const Moment& moment) const override;
  void observe(const Moment& moment) override;
  void finish(const Moment& moment) override;
  void sync() override { table_.sync(); }

 protected:
  /// The columns after `step`; only asked for when the table is wanted. Collective.
  virtual std::vector<double> row(const Moment& moment) = 0;
  long interval() const { return interval_; }

 private:
  TableRun tableRun(const OutputContext& context) const;
  void record(const Moment& moment);

  TableMonitor table_;
  long interval_;
  bool restart_ = false;
};

/// The name of the column with the time.
std::string timeColumn(const UnitSystem& units);

}  // namespace nanoweft
