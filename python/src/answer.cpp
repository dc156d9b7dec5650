#include "answer.hpp"

#include "output/report/certificate_report.hpp"
#include "output/report/report.hpp"
#include "output/solution/solution_json.hpp"
#include "summary/embedded_report.hpp"

namespace conddp::python {
namespace {

OrderedJson document_of(const Answer& answer) {
  const Solution solution = answer.solution();
  OrderedJson document = solution_json(solution);
  if (answer.certificate) {
    SolutionCertificate certificate = *answer.certificate;
    note_nulls(document, certificate.checks);
    add_certificate(certificate_json(certificate), document);
  }
  return document;
}

std::string page_of(const Answer& answer, const OrderedJson& document) {
  if (!missing_for_reports().empty())
    throw std::runtime_error("reports cannot be made: " + std::string(missing_for_reports()));
  return report_page(std::string(report_template()), report_data({{.label = answer.solver_name(),
                                                                   .document = document,
                                                                   .built = &answer.task.built}}));
}

}  // namespace

Solution Answer::solution() const {
  return {task.built, *solver, result, settings, mesh};
}

std::string Answer::verdict() const {
  return certificate ? std::string(to_string(certificate->checks.verdict())) : "";
}

bool Answer::solved() const {
  return is_success(result.status) &&
         (!certificate || !is_denied(certificate->checks.verdict()));
}

std::string Answer::names() const { return motion_names(task.built).dump(); }

std::string Answer::document() const { return document_of(*this).dump(); }

std::string Answer::certificate_text() const {
  return certificate ? certificate_json(*certificate).dump() : "null";
}

std::string Answer::page() const { return page_of(*this, document_of(*this)); }

std::vector<std::string> Answer::write(const std::string& folder, bool with_page) const {
  const OrderedJson document = document_of(*this);
  std::vector<std::string> written;
  for (const auto& path : write_solution(solution(), document, folder,
                                         with_page ? page_of(*this, document) : std::string()))
    written.push_back(path.string());
  return written;
}

}  // namespace conddp::python
