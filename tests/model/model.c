/* Models with the C interface of CasADi's generated code, written by hand. */
#include <math.h>

typedef long long Int;

#define COUNT(list) ((Int)(sizeof(list) / sizeof(list[0])))

/* Full matrices, and column-wise patterns. */
static const Int scalar[] = {1, 1, 1};
static const Int pair[] = {2, 1, 1};
static const Int triple[] = {3, 1, 1};
static const Int nothing[] = {0, 1, 1};
static const Int empty_pair[] = {2, 1, 0, 0};

/* Everything about a function except its values and workspace. */
#define DESCRIBE(f)                                                                  \
  Int f##_n_in(void) { return COUNT(f##_in); }                                       \
  Int f##_n_out(void) { return COUNT(f##_out); }                                     \
  const char* f##_name_in(Int i) { return f##_in[i].name; }                          \
  const char* f##_name_out(Int i) { return f##_out[i].name; }                        \
  const Int* f##_sparsity_in(Int i) { return f##_in[i].pattern; }                    \
  const Int* f##_sparsity_out(Int i) { return f##_out[i].pattern; }                  \
  int f##_work(Int* arg, Int* res, Int* iw, Int* w) {                                \
    *arg = COUNT(f##_in) + 2;                                                        \
    *res = COUNT(f##_out) + 2;                                                       \
    *iw = 1;                                                                         \
    *w = 4;                                                                          \
    return 0;                                                                        \
  }
#define ARGUMENTS const double **arg, double **res, Int *iw, double *w, int mem

typedef struct {
  const char* name;
  const Int* pattern;
} Port;

/* Number of workspaces checked out and not released. */
static int checked_out = 0;
int workspaces_in_use(void) { return checked_out; }

/* A swing with a spring that stiffens: p = (inertia, weight), rate (speed, torque - weight*sin(angle)
   - 0.1*speed*angle^2)/inertia. */
static const Port swing_in[] = {{"x", pair}, {"u", scalar}, {"p", pair}};
static const Port swing_out[] = {{"rate", pair}};
DESCRIBE(swing)
int swing_checkout(void) { return ++checked_out; }
void swing_release(int mem) {
  (void)mem;
  --checked_out;
}
int swing(ARGUMENTS) {
  const double *x = arg[0], *u = arg[1], *p = arg[2];
  (void)mem;
  iw[0] = 1;
  w[3] = x[0] * x[0];
  if (res[0]) {
    res[0][0] = x[1];
    res[0][1] = (u[0] - p[1] * sin(x[0]) - 0.1 * x[1] * w[3]) / p[0];
  }
  arg[3] = 0; /* what follows the arguments belongs to the function */
  return 0;
}
static const Int jac_swing_x_pattern[] = {2, 2, 0, 1, 3, 1, 0, 1};
static const Int second_row[] = {2, 1, 0, 1, 1};
static const Port jac_swing_in[] = {{"x", pair}, {"u", scalar}, {"p", pair}, {"out_rate", empty_pair}};
static const Port jac_swing_out[] = {{"jac_rate_x", jac_swing_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_swing)
int jac_swing(ARGUMENTS) {
  const double *x = arg[0], *p = arg[2];
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = (-p[1] * cos(x[0]) - 0.2 * x[1] * x[0]) / p[0];
    res[0][1] = 1;
    res[0][2] = -0.1 * x[0] * x[0] / p[0];
  }
  if (res[1]) res[1][0] = 1 / p[0];
  return 0;
}
static const Int hess_swing_pattern[] = {3, 3, 0, 2, 3, 3, 0, 1, 0};
static const Port hess_swing_in[] = {{"x", pair}, {"u", scalar}, {"p", pair}, {"lam", pair}};
static const Port hess_swing_out[] = {{"hess", hess_swing_pattern}};
DESCRIBE(hess_swing)
int hess_swing(ARGUMENTS) {
  const double *x = arg[0], *p = arg[2], l = arg[3][1] / p[0];
  (void)iw, (void)w, (void)mem;
  res[0][0] = l * (p[1] * sin(x[0]) - 0.2 * x[1]);
  res[0][1] = res[0][2] = -l * 0.2 * x[0];
  return 0;
}

/* The swing with a Hessian that lacks an entry. */
static const Port bent_in[] = {{"x", pair}, {"u", scalar}, {"p", pair}};
static const Port bent_out[] = {{"rate", pair}};
DESCRIBE(bent)
int bent(ARGUMENTS) { return swing(arg, res, iw, w, mem); }
static const Port jac_bent_in[] = {{"x", pair}, {"u", scalar}, {"p", pair}};
static const Port jac_bent_out[] = {{"jac_rate_x", jac_swing_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_bent)
int jac_bent(ARGUMENTS) { return jac_swing(arg, res, iw, w, mem); }
static const Port hess_bent_in[] = {{"x", pair}, {"u", scalar}, {"p", pair}, {"lam", pair}};
static const Port hess_bent_out[] = {{"hess", hess_swing_pattern}};
DESCRIBE(hess_bent)
int hess_bent(ARGUMENTS) {
  hess_swing(arg, res, iw, w, mem);
  res[0][1] = res[0][2] = 0;
  return 0;
}

/* In a wind: rate (speed, torque - sin(angle) + 0.3*sin(2*t)). */
static const Port wind_in[] = {{"t", scalar}, {"u", scalar}, {"x", pair}};
static const Port wind_out[] = {{"rate", pair}};
DESCRIBE(wind)
int wind(ARGUMENTS) {
  const double *x = arg[2], *u = arg[1];
  (void)iw, (void)w, (void)mem;
  res[0][0] = x[1];
  res[0][1] = u[0] - sin(x[0]) + 0.3 * sin(2 * arg[0][0]);
  return 0;
}
static const Port jac_wind_in[] = {{"t", scalar}, {"u", scalar}, {"x", pair}, {"out_rate", pair}};
static const Int jac_wind_x_pattern[] = {2, 2, 0, 1, 2, 1, 0};
static const Port jac_wind_out[] = {
    {"jac_rate_t", second_row}, {"jac_rate_u", second_row}, {"jac_rate_x", jac_wind_x_pattern}};
DESCRIBE(jac_wind)
int jac_wind(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) res[0][0] = 0.6 * cos(2 * arg[0][0]);
  if (res[1]) res[1][0] = 1;
  if (res[2]) {
    res[2][0] = -cos(arg[2][0]);
    res[2][1] = 1;
  }
  return 0;
}

/* With drag: acceleration push - 0.4*v^2 of positions and velocities (y, v). */
static const Port fall_in[] = {{"x", pair}, {"u", scalar}};
static const Port fall_out[] = {{"a", scalar}};
DESCRIBE(fall)
int fall(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[1][0] - 0.4 * arg[0][1] * arg[0][1];
  return 0;
}
static const Int second_of_two[] = {1, 2, 0, 0, 1, 0};
static const Port jac_fall_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_fall_out[] = {{"jac_a_x", second_of_two}, {"jac_a_u", scalar}};
DESCRIBE(jac_fall)
int jac_fall(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) res[0][0] = -0.8 * arg[0][1];
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* A residual: the height of a tip at the end of p = (length), and the power. */
static const Port reach_in[] = {{"x", pair}, {"u", scalar}, {"p", scalar}};
static const Port reach_out[] = {{"r", pair}};
DESCRIBE(reach)
int reach(ARGUMENTS) {
  const double *x = arg[0], *u = arg[1];
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[2][0] * sin(x[0]);
  res[0][1] = u[0] * x[1];
  return 0;
}
static const Int diagonal[] = {2, 2, 0, 1, 2, 0, 1};
static const Port jac_reach_in[] = {{"x", pair}, {"u", scalar}, {"p", scalar}};
static const Port jac_reach_out[] = {{"jac_r_x", diagonal}, {"jac_r_u", second_row}};
DESCRIBE(jac_reach)
int jac_reach(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = arg[2][0] * cos(arg[0][0]);
    res[0][1] = arg[1][0];
  }
  if (res[1]) res[1][0] = arg[0][1];
  return 0;
}

/* A time-dependent residual: x - t. */
static const Port late_in[] = {{"x", pair}, {"t", scalar}, {"u", nothing}};
static const Port late_out[] = {{"r", scalar}};
DESCRIBE(late)
int late(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][0] - arg[1][0];
  return 0;
}
static const Int first_of_two[] = {1, 2, 0, 1, 1, 0};
static const Port jac_late_in[] = {{"x", pair}, {"t", scalar}};
static const Port jac_late_out[] = {{"jac_r_x", first_of_two}, {"jac_r_t", scalar}};
DESCRIBE(jac_late)
int jac_late(ARGUMENTS) {
  (void)arg, (void)iw, (void)w, (void)mem;
  if (res[0]) res[0][0] = 1;
  if (res[1]) res[1][0] = -1;
  return 0;
}

/* Its Jacobian is wrong: rate (y, u - x), with a claimed derivative of 2 with respect to u. */
static const Port crooked_in[] = {{"x", pair}, {"u", scalar}}, crooked_out[] = {{"rate", pair}};
DESCRIBE(crooked)
int crooked(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] - arg[0][0];
  return 0;
}
static const Port jac_crooked_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_crooked_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_crooked)
int jac_crooked(ARGUMENTS) {
  (void)arg, (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = -1;
    res[0][1] = 1;
  }
  if (res[1]) res[1][0] = 2;
  return 0;
}

/* Numbers of very different magnitude: a climb in metres through thinning air. */
static const Port climb_in[] = {{"x", pair}, {"u", scalar}}, climb_out[] = {{"rate", pair}};
DESCRIBE(climb)
int climb(ARGUMENTS) {
  const double *x = arg[0], drag = 9.81e-5 * exp(-x[0] / 8000);
  (void)iw, (void)w, (void)mem;
  res[0][0] = x[1];
  res[0][1] = arg[1][0] - drag * x[1] * x[1] - 9.81;
  return 0;
}
static const Port jac_climb_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_climb_out[] = {{"jac_rate_x", jac_swing_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_climb)
int jac_climb(ARGUMENTS) {
  const double *x = arg[0], drag = 9.81e-5 * exp(-x[0] / 8000);
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = drag * x[1] * x[1] / 8000;
    res[0][1] = 1;
    res[0][2] = -2 * drag * x[1];
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* With a kink at zero: rate (y, u - max(x, 0)). The derivative at zero is one-sided, from above. */
static const Port kink_in[] = {{"x", pair}, {"u", scalar}}, kink_out[] = {{"rate", pair}};
DESCRIBE(kink)
int kink(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] - fmax(arg[0][0], 0);
  return 0;
}
static const Port jac_kink_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_kink_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_kink)
int jac_kink(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = arg[0][0] < 0 ? 0 : -1;
    res[0][1] = 1;
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* With an edge: rate (y, u - x^1.5), defined only for x >= 0. */
static const Port edge_in[] = {{"x", pair}, {"u", scalar}}, edge_out[] = {{"rate", pair}};
DESCRIBE(edge)
int edge(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] - pow(arg[0][0], 1.5);
  return arg[0][0] < 0;
}
static const Port jac_edge_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_edge_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_edge)
int jac_edge(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = -1.5 * sqrt(arg[0][0]);
    res[0][1] = 1;
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* rate (y, u + exp(x)); its Jacobian reads the rate. */
static const Port growth_in[] = {{"x", pair}, {"u", scalar}}, growth_out[] = {{"rate", pair}};
DESCRIBE(growth)
int growth(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] + exp(arg[0][0]);
  return 0;
}
static const Port jac_growth_in[] = {{"x", pair}, {"u", scalar}, {"out_rate", pair}};
static const Port jac_growth_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_growth)
int jac_growth(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = arg[2][1] - arg[1][0];
    res[0][1] = 1;
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* Waves: rate (y, u - sin(x)). Steps as large as the coordinates span periods. The Jacobian of
   wrong_wave is wrong. */
static const Port wave_in[] = {{"x", pair}, {"u", scalar}}, wave_out[] = {{"rate", pair}};
DESCRIBE(wave)
int wave(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] - sin(arg[0][0]);
  return 0;
}
static const Port jac_wave_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_wave_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_wave)
int jac_wave(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = -cos(arg[0][0]);
    res[0][1] = 1;
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}
static const Port wrong_wave_in[] = {{"x", pair}, {"u", scalar}}, wrong_wave_out[] = {{"rate", pair}};
DESCRIBE(wrong_wave)
int wrong_wave(ARGUMENTS) { return wave(arg, res, iw, w, mem); }
static const Port jac_wrong_wave_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_wrong_wave_out[] = {{"jac_rate_x", jac_wind_x_pattern},
                                          {"jac_rate_u", second_row}};
DESCRIBE(jac_wrong_wave)
int jac_wrong_wave(ARGUMENTS) {
  jac_wave(arg, res, iw, w, mem);
  if (res[0]) res[0][0] += 0.2;
  return 0;
}

/* On a terrain: rate (y, u - sin(x/10)). */
static const Port terrain_in[] = {{"x", pair}, {"u", scalar}}, terrain_out[] = {{"rate", pair}};
DESCRIBE(terrain)
int terrain(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] - sin(arg[0][0] / 10);
  return 0;
}
static const Port jac_terrain_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_terrain_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
DESCRIBE(jac_terrain)
int jac_terrain(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = -cos(arg[0][0] / 10) / 10;
    res[0][1] = 1;
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* With nearly dry friction: rate (y, u - tanh(y/1e-4)). */
static const Port friction_in[] = {{"x", pair}, {"u", scalar}}, friction_out[] = {{"rate", pair}};
DESCRIBE(friction)
int friction(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] - tanh(arg[0][1] / 1e-4);
  return 0;
}
static const Port jac_friction_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_friction_out[] = {{"jac_rate_x", jac_swing_x_pattern},
                                        {"jac_rate_u", second_row}};
DESCRIBE(jac_friction)
int jac_friction(ARGUMENTS) {
  const double steep = cosh(arg[0][1] / 1e-4);
  (void)iw, (void)w, (void)mem;
  if (res[0]) {
    res[0][0] = 0;
    res[0][1] = 1;
    res[0][2] = -1e4 / (steep * steep);
  }
  if (res[1]) res[1][0] = 1;
  return 0;
}

/* An alternating current: rate (y, u + sin(2*pi*50*t)). */
static const double kMains = 314.15926535897932;
static const Port hum_in[] = {{"x", pair}, {"u", scalar}, {"t", scalar}}, hum_out[] = {{"rate", pair}};
DESCRIBE(hum)
int hum(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][1];
  res[0][1] = arg[1][0] + sin(kMains * arg[2][0]);
  return 0;
}
static const Port jac_hum_in[] = {{"x", pair}, {"u", scalar}, {"t", scalar}};
static const Int upper_right[] = {2, 2, 0, 0, 1, 0};
static const Port jac_hum_out[] = {
    {"jac_rate_x", upper_right}, {"jac_rate_u", second_row}, {"jac_rate_t", second_row}};
DESCRIBE(jac_hum)
int jac_hum(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  if (res[0]) res[0][0] = 1;
  if (res[1]) res[1][0] = 1;
  if (res[2]) res[2][0] = kMains * cos(kMains * arg[2][0]);
  return 0;
}

/* A residual of an arm with seven joints: its first angle. */
static const Int fourteen[] = {14, 1, 1};
static const Int first_of_fourteen[] = {1, 14, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0};
static const Port joint_in[] = {{"x", fourteen}}, joint_out[] = {{"r", scalar}};
DESCRIBE(joint)
int joint(ARGUMENTS) {
  (void)iw, (void)w, (void)mem;
  res[0][0] = arg[0][0];
  return 0;
}
static const Port jac_joint_in[] = {{"x", fourteen}}, jac_joint_out[] = {{"jac_r_x", first_of_fourteen}};
DESCRIBE(jac_joint)
int jac_joint(ARGUMENTS) {
  (void)arg, (void)iw, (void)w, (void)mem;
  if (res[0]) res[0][0] = 1;
  return 0;
}

/* Unusable functions. */
static int fails(ARGUMENTS) {
  (void)arg, (void)res, (void)iw, (void)w, (void)mem;
  return 1;
}
#define BROKEN(f) \
  DESCRIBE(f)     \
  int f(ARGUMENTS) { return fails(arg, res, iw, w, mem); }

static const Port lonely_in[] = {{"x", pair}, {"u", scalar}}, lonely_out[] = {{"rate", pair}};
BROKEN(lonely) /* has no jac_lonely */
static const Port odd_in[] = {{"x", pair}, {"force", scalar}}, odd_out[] = {{"rate", pair}};
BROKEN(odd) /* has an input of another name */
static const Port flat_in[] = {{"x", pair}}, flat_out[] = {{"rate", jac_swing_x_pattern}};
BROKEN(flat) /* is no vector */
static const Port many_in[] = {{"x", pair}, {"u", scalar}}, many_out[] = {{"rate", triple}};
BROKEN(many) /* has more rows than states */
static const Port jac_many_in[] = {{"x", pair}, {"u", scalar}};
static const Int three_by_two[] = {3, 2, 1}, three_by_one[] = {3, 1, 1};
static const Port jac_many_out[] = {{"jac_rate_x", three_by_two}, {"jac_rate_u", three_by_one}};
BROKEN(jac_many)
static const Port thin_in[] = {{"x", pair}, {"u", scalar}}, thin_out[] = {{"rate", pair}};
BROKEN(thin) /* has a Jacobian of another size */
static const Port jac_thin_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_thin_out[] = {{"jac_rate_x", pair}, {"jac_rate_u", pair}};
BROKEN(jac_thin)
static const Port nameless_in[] = {{"x", pair}, {"u", scalar}}, nameless_out[] = {{"rate", pair}};
BROKEN(nameless) /* has a Jacobian without the names of its parts */
static const Port jac_nameless_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_nameless_out[] = {{"jac", jac_swing_x_pattern}};
BROKEN(jac_nameless)
static const Port weightless_in[] = {{"x", pair}, {"u", scalar}}, weightless_out[] = {{"rate", pair}};
BROKEN(weightless) /* has a Hessian of no weights */
static const Port jac_weightless_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_weightless_out[] = {{"jac_rate_x", jac_swing_x_pattern},
                                          {"jac_rate_u", second_row}};
BROKEN(jac_weightless)
static const Port hess_weightless_in[] = {{"x", pair}}, hess_weightless_out[] = {{"hess", hess_swing_pattern}};
BROKEN(hess_weightless)
static const Port torn_in[] = {{"x", pair}, {"u", scalar}}, torn_out[] = {{"rate", pair}};
BROKEN(torn) /* fails whenever it is called */
static const Port jac_torn_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_torn_out[] = {{"jac_rate_x", jac_swing_x_pattern}, {"jac_rate_u", second_row}};
BROKEN(jac_torn)
static const Port stuck_in[] = {{"x", pair}, {"u", scalar}}, stuck_out[] = {{"rate", pair}};
DESCRIBE(stuck) /* has a Jacobian that fails whenever it is called */
int stuck(ARGUMENTS) { return crooked(arg, res, iw, w, mem); }
static const Port jac_stuck_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_stuck_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
BROKEN(jac_stuck)
static const Port strange_in[] = {{"x", pair}, {"u", scalar}}, strange_out[] = {{"rate", pair}};
BROKEN(strange) /* has a Hessian with an input that is not known */
static const Port jac_strange_in[] = {{"x", pair}, {"u", scalar}};
static const Port jac_strange_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
BROKEN(jac_strange)
static const Port hess_strange_in[] = {{"x", pair}, {"lam", pair}, {"lam_of_y", pair}};
static const Port hess_strange_out[] = {{"hess", hess_swing_pattern}};
BROKEN(hess_strange)
static const Port alien_in[] = {{"x", pair}, {"u", scalar}}, alien_out[] = {{"rate", pair}};
BROKEN(alien) /* has a Jacobian that reads an output that there is not */
static const Port jac_alien_in[] = {{"x", pair}, {"u", scalar}, {"out_force", pair}};
static const Port jac_alien_out[] = {{"jac_rate_x", jac_wind_x_pattern}, {"jac_rate_u", second_row}};
BROKEN(jac_alien)
static const Int impossible[] = {-1, 4, 1};
static const Port garbled_in[] = {{"x", impossible}}, garbled_out[] = {{"rate", pair}};
BROKEN(garbled) /* describes no matrix */
