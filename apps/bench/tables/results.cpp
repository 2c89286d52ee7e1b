#include "apps/bench/tables/results.h"

namespace tribotrack::bench {

std::vector<BenchTable> tables_of(const BenchResults& results, const std::vector<std::string>& missing) {
  std::vector<BenchTable> tables;
  if (const auto& model = results.model) {
    tables.push_back(table_of(model->rows, missing));
    tables.push_back(table_of(model->extremes));
    tables.push_back(table_of(model->omissions));
    tables.push_back(table_of(model->batches));
    tables.push_back(table_of(model->claims));
  }
  if (const auto& vision = results.vision) {
    tables.push_back(table_of(vision->rows));
    tables.push_back(table_of(vision->limits));
    tables.push_back(audit_table_of(vision->limits));
    tables.push_back(table_of(vision->decodings));
  }
  if (results.commands) tables.push_back(table_of(*results.commands));
  if (const auto& fit = results.fit) {
    tables.push_back(table_of(fit->rows));
    tables.push_back(table_of(fit->filmed));
  }
  if (results.coverage) tables.push_back(table_of(results.coverage->rows));
  if (results.scale) {
    tables.push_back(table_of(*results.scale));
    tables.push_back(table_of(exponents(*results.scale)));
  }
  return tables;
}

}  // namespace tribotrack::bench
