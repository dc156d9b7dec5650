# The layers of src/, lowest first. A layer may include itself and the layers before it, nothing else.
set(CONDDP_LAYERS base spatial robot systems ocp nlp solvers mpc analysis problem_file output batch)

# The folders of layers that have some, lowest first, with the same rule; "." is the layer's own
# folder. scripts/check_layers reads all of these lists.
set(CONDDP_base_FOLDERS . text files json)
set(CONDDP_robot_FOLDERS . urdf)
set(CONDDP_systems_FOLDERS . multibody contact graphs expressions libraries closed_forms)
set(CONDDP_ocp_FOLDERS terms step residuals knot problem evaluation)
set(CONDDP_nlp_FOLDERS . ipopt)
set(CONDDP_solvers_FOLDERS
  common linalg stages riccati iterate constraints globalization ddp interior ipopt sampling strategies)
set(CONDDP_analysis_FOLDERS derivatives certificate contact findings comparison terminal margins)
set(CONDDP_problem_file_FOLDERS yaml model values data plant motion residuals lower read mesh terms assemble expand first_problem)
set(CONDDP_output_FOLDERS solution schedule scene mpc report bench)
set(CONDDP_batch_FOLDERS plan results run cluster session)

# The folders of the tool, apps/conddp, lowest first, with the same rule: the process and its streams,
# what stands on a command line, what the tool says about itself and about problems and answers, and the
# subcommands; "." has main.cpp. All of them stand above the layers.
set(CONDDP_TOOL_FOLDERS terminal arguments help summary commands .)

# Names of features and the places that may know them: decorations of a step are made where problems are
# built, and the specification of a file stays there; others ask the built problem.
set(CONDDP_OWN_NAMES
  make_controls_linear=src/ocp/step,src/problem_file
  has_linear_controls=src/ocp/step,src/problem_file
  remember_controls=src/ocp/step,src/problem_file
  scale_time=src/ocp/step,src/problem_file
  HeldControls=src/problem_file/assemble
  ProblemSpec=src/problem_file
  problem_spec=src/problem_file
  StateTail=src/problem_file/assemble)
