// The only symbol of the shared library that conddp loads for the solver `ipopt`.
#include "nlp/ipopt/ipopt_minimise.hpp"
#include "nlp/ipopt/option_trial.hpp"
#include "nlp/ipopt/registered_options.hpp"
#include "nlp/ipopt_library.hpp"

extern "C" __attribute__((visibility("default"))) const conddp::IpoptLibrary conddp_ipopt_library;

extern "C" const conddp::IpoptLibrary conddp_ipopt_library = {
    .minimise = conddp::ipopt_minimise,
    .option_names = conddp::registered_option_names,
    .is_integer_option = conddp::is_registered_integer,
    .check_option = conddp::check_registered_option,
    .first_unusable = conddp::first_unusable_option,
};
