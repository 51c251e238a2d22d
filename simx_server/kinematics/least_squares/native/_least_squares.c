/* Inverse kinematics by least squares: what ../in_python.py, ../rows.py and ../steps.py do, on the arrays of ../problem.py.

   The same operations in the same order, so both forms give the same numbers bit for bit: no sum is reordered, and the
   build forbids fused multiplications (-ffp-contract=off). A formula that changes here changes there;
   tests/server/kinematics/test_compiled_least_squares.py holds both equal.

   The interpreter's lock is released while states are looked at: the object never changes, and a call has memory of its
   own. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>
#include <structmember.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* as in the modules in Python */
#define ENOUGH 0.01
#define STUCK 1e-7
#define HALVINGS 6
#define LEAST_DAMPING 1e-3
#define TINY 1e-9
#define LARGER 1099511627776.0 /* 2 to the power of 40 */
enum { TRANSPOSE, DAMPED, ADAPTIVE };
enum { HINGE, SLIDE, BALL };
enum { ALPHA_BETA = 8, GAMMA = 16 };

#define MOST 100000 /* links, columns or elements: products of two fit into 64 bits */

/* Compilers replace both of one angle by sincos, whose last bit may differ from that of sin. */
static double (*const volatile sine)(double) = sin;
static double (*const volatile cosine)(double) = cos;


//------------------------------------------ poses -------------------------------------------------

typedef struct {
  double place[3], turn[4]; /* w x y z */
} Pose;

static double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(double* found, const double* a, const double* b) {
  found[0] = a[1] * b[2] - a[2] * b[1];
  found[1] = a[2] * b[0] - a[0] * b[2];
  found[2] = a[0] * b[1] - a[1] * b[0];
}

static void subtract(double* found, const double* a, const double* b) {
  for (int i = 0; i < 3; i++) {
    found[i] = a[i] - b[i];
  }
}

static double length(const double* vector, int count) {
  double square = 0.0;
  for (int i = 0; i < count; i++) {
    square += vector[i] * vector[i];
  }
  return sqrt(square);
}

static void multiply(double* found, const double* a, const double* b) {
  double product[4] = {
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  };
  memcpy(found, product, sizeof(product));
}

static void rotate(double* found, const double* q, const double* v) {
  double w = q[0], x = q[1], y = q[2], z = q[3];
  double tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]), tz = 2 * (x * v[1] - y * v[0]);
  found[0] = v[0] + w * tx + y * tz - z * ty;
  found[1] = v[1] + w * ty + z * tx - x * tz;
  found[2] = v[2] + w * tz + x * ty - y * tx;
}

static void compose(Pose* found, const Pose* outer, const Pose* inner) {
  double turned[3];
  rotate(turned, outer->turn, inner->place);
  for (int i = 0; i < 3; i++) {
    found->place[i] = outer->place[i] + turned[i];
  }
  multiply(found->turn, outer->turn, inner->turn);
}

/* A world pose in a frame of the world. */
static void see_from(Pose* found, const Pose* frame, const Pose* pose) {
  Pose back = {{0}, {frame->turn[0], -frame->turn[1], -frame->turn[2], -frame->turn[3]}};
  rotate(back.place, back.turn, frame->place);
  for (int i = 0; i < 3; i++) {
    back.place[i] = back.place[i] * -1.0;
  }
  compose(found, &back, pose);
}

static void about(double* found, const double* axis, double angle) {
  double half = isfinite(angle) ? angle / 2 : NAN, s = sine(half);
  found[0] = cosine(half);
  for (int i = 0; i < 3; i++) {
    found[1 + i] = axis[i] * s;
  }
}

/* The rotation matrix, row by row; `is_transposed`: its columns one after the other. */
static void matrix(double* found, const double* q, int is_transposed) {
  double w = q[0], x = q[1], y = q[2], z = q[3];
  double rows[9] = {
    1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
  };
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      found[3 * i + j] = is_transposed ? rows[3 * j + i] : rows[3 * i + j];
    }
  }
}

static void normalise(double* q) {
  double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (isinf(size)) { /* the squares overflowed */
    double largest = fabs(q[0]);
    for (int i = 1; i < 4; i++) {
      largest = fabs(q[i]) > largest ? fabs(q[i]) : largest;
    }
    for (int i = 0; i < 4; i++) {
      q[i] /= largest;
    }
    size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  }
  for (int i = 0; i < 4; i++) {
    q[i] /= size;
  }
}

static void turn_z_to(double* found, const double* axis) {
  double x = axis[0], y = axis[1], z = axis[2], across = x * x + y * y;
  if (z < 0 && across < 1e-30) {
    memcpy(found, (double[4]){0.0, 1.0, 0.0, 0.0}, 4 * sizeof(double));
    return;
  }
  double w = z < 0 ? across / (1.0 - z) : 1.0 + z;
  memcpy(found, (double[4]){LARGER * w, -LARGER * y, LARGER * x, 0.0}, 4 * sizeof(double));
  normalise(found);
}

/* Axis times angle. */
static void rotation_vector(double* found, const double* turn) {
  double sign = turn[0] < 0 ? -1.0 : 1.0, q[4];
  for (int i = 0; i < 4; i++) {
    q[i] = sign * turn[i];
  }
  double s = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), factor = 2;
  if (!(s < 1e-15)) {
    factor = 2 * atan2(s, q[0]) / s;
  }
  for (int i = 0; i < 3; i++) {
    found[i] = q[1 + i] * factor;
  }
}

/* The rotation from one orientation to another, in the frame of the first. */
static void turn_between(double* found, const double* from, const double* to) {
  double back[4] = {from[0], -from[1], -from[2], -from[3]};
  multiply(found, back, to);
}


//------------------------------------------ problem -----------------------------------------------

typedef struct {
  int32_t before, kind, column;
  Pose fixed;
} Link;

typedef struct {
  int32_t tip_link, base_link, constraints;
  Pose tip, base;
  double weights[2], precision[2];
  const char* used; /* (m,) */
} End;

typedef struct {
  PyObject_HEAD
  Py_ssize_t links, ends, columns, balls;
  Py_ssize_t rows;
  Link* link;
  End* end;
  double *low, *high, *steps, *eagerness; /* (m,) each, of one piece */
  char* used;
} Problem;

/* What the joints' values lead to. */
typedef struct {
  double *values, *turns; /* (m,), (b, 4) */
  double *error, *jacobian; /* (k,), (k, m) */
  double *misses; /* (e, 2) */
} State;

typedef struct {
  const Problem* p;
  Pose* poses; /* (l,) */
  double* axes; /* (l, 9) one axis of a hinge or slide, three of a spherical joint */
  double* columns; /* (m, 3) */
  State now, trial;
  double *change, *eager, *scaled, *square, *right; /* (m,), (m,), (k, m), (k, k), (k,) */
} Work;

/* Give a call its memory, in one piece, which the caller frees. */
static void* furnish(Work* work, const Problem* p) {
  size_t l = (size_t)p->links, e = (size_t)p->ends, m = (size_t)p->columns, b = (size_t)p->balls, k = (size_t)p->rows;
  size_t state = m + 4 * b + k + k * m + 2 * e;
  size_t all = 9 * l + 3 * m + 2 * state + 2 * m + k * m + k * k + k;
  char* memory = malloc(l * sizeof(Pose) + (all + 1) * sizeof(double));
  if (!memory) {
    return NULL;
  }
  work->p = p;
  work->poses = (Pose*)memory;
  double* at = (double*)(work->poses + l);
  work->axes = at, at += 9 * l;
  work->columns = at, at += 3 * m;
  State* states[] = {&work->now, &work->trial};
  for (int i = 0; i < 2; i++) {
    states[i]->values = at, at += m;
    states[i]->turns = at, at += 4 * b;
    states[i]->error = at, at += k;
    states[i]->jacobian = at, at += k * m;
    states[i]->misses = at, at += 2 * e;
  }
  work->change = at, at += m;
  work->eager = at, at += m;
  work->scaled = at, at += k * m;
  work->square = at, at += k * k;
  work->right = at;
  return memory;
}


//------------------------------------------ where everything is -----------------------------------

/* The value of a spherical joint after the turn in the values. */
static void turned(double* found, const Problem* p, const State* state, Py_ssize_t ball) {
  const double* way = state->values + p->columns - 3 * p->balls + 3 * ball;
  double angle = length(way, 3), axis[3] = {0.0, 0.0, 1.0}, turn[4];
  if (angle > 0) {
    for (int i = 0; i < 3; i++) {
      axis[i] = way[i] / angle;
    }
  }
  about(turn, axis, angle);
  multiply(found, state->turns + 4 * ball, turn);
}

static void place_links(Work* work, const State* state) {
  const Problem* p = work->p;
  static const double z[3] = {0.0, 0.0, 1.0};
  for (Py_ssize_t i = 0; i < p->links; i++) {
    const Link* link = p->link + i;
    Pose* pose = work->poses + i;
    double *axis = work->axes + 9 * i, turn[4];
    if (link->before < 0) {
      *pose = link->fixed;
    } else {
      compose(pose, work->poses + link->before, &link->fixed);
    }
    if (link->kind == BALL) {
      turned(turn, p, state, (link->column - (p->columns - 3 * p->balls)) / 3);
      multiply(pose->turn, pose->turn, turn);
      matrix(axis, pose->turn, 1);
      continue;
    }
    double w = pose->turn[0], x = pose->turn[1], y = pose->turn[2];
    axis[0] = 2 * (x * pose->turn[3] + w * y);
    axis[1] = 2 * (y * pose->turn[3] - w * x);
    axis[2] = 1 - 2 * (x * x + y * y);
    double value = state->values[link->column];
    if (link->kind == SLIDE) {
      for (int j = 0; j < 3; j++) {
        pose->place[j] = pose->place[j] + axis[j] * value;
      }
    } else {
      about(turn, z, value);
      multiply(pose->turn, pose->turn, turn);
    }
  }
}

static void carried(Pose* found, const Work* work, int32_t link, const Pose* local) {
  if (link < 0) {
    *found = *local;
  } else {
    compose(found, work->poses + link, local);
  }
}

/* How a point, or with NULL the turn, of what the tip's link carries changes with each column: `End._columns`. */
static void find_columns(Work* work, const End* end, const double* point) {
  const Problem* p = work->p;
  memset(work->columns, 0, 3 * (size_t)p->columns * sizeof(double));
  for (int32_t number = end->tip_link; number >= 0; number = p->link[number].before) {
    const Link* link = p->link + number;
    for (int i = 0; i < (link->kind == BALL ? 3 : 1); i++) {
      double *column = work->columns + 3 * (link->column + i), *axis = work->axes + 9 * number + 3 * i, away[3];
      if (!end->used[link->column + i] || (link->kind == SLIDE && !point)) {
        continue;
      }
      if (link->kind == SLIDE || !point) {
        memcpy(column, axis, 3 * sizeof(double));
      } else {
        subtract(away, point, work->poses[number].place);
        cross(column, axis, away);
      }
    }
  }
}

static void add_row(const Work* work, State* state, Py_ssize_t row, const double* axis, double weight) {
  double* found = state->jacobian + row * work->p->columns;
  for (Py_ssize_t j = 0; j < work->p->columns; j++) {
    found[j] = dot(axis, work->columns + 3 * j) * weight;
  }
}

/* `End._turn`: about which axes of the tip it shall turn, from the first to before the last, and how far. */
static void choose_turn(const End* end, double* turn, int* first, int* last) {
  *first = 0, *last = 0;
  if (end->constraints & GAMMA) {
    *last = 3;
    if (!(end->constraints & ALPHA_BETA)) {
      *first = 2;
      if (fabs(turn[0]) + fabs(turn[3]) > TINY) {
        turn[1] = turn[2] = 0.0;
        normalise(turn);
      } else {
        memcpy(turn, (double[4]){1.0, 0.0, 0.0, 0.0}, 4 * sizeof(double));
      }
    }
  } else if (end->constraints & ALPHA_BETA) {
    double rows[9];
    *last = 2;
    matrix(rows, turn, 0);
    turn_z_to(turn, (double[3]){rows[2], rows[5], rows[8]});
  }
}

/* `End.rows`, from a row on; return the row after the last. */
static Py_ssize_t add_rows(Work* work, State* state, Py_ssize_t row, Py_ssize_t number, const Pose* goal) {
  const End* end = work->p->end + number;
  Py_ssize_t begin = row;
  Pose tip;
  double axes[9], vector[3], turn[4];
  carried(&tip, work, end->tip_link, &end->tip);
  if (end->constraints & 7) {
    memcpy(turn, end->base.turn, sizeof(turn));
    if (end->base_link >= 0) {
      multiply(turn, work->poses[end->base_link].turn, turn);
    }
    matrix(axes, turn, 1);
    subtract(vector, goal->place, tip.place);
    find_columns(work, end, tip.place);
    for (int i = 0; i < 3; i++) {
      if (end->constraints & (1 << i)) {
        state->error[row] = dot(axes + 3 * i, vector);
        add_row(work, state, row++, axes + 3 * i, end->weights[0]);
      }
    }
  }
  Py_ssize_t straight = row;
  int first, last;
  turn_between(turn, tip.turn, goal->turn);
  choose_turn(end, turn, &first, &last);
  if (first < last) {
    rotation_vector(vector, turn);
    matrix(axes, tip.turn, 1);
    find_columns(work, end, NULL);
    for (int i = first; i < last; i++) {
      state->error[row] = vector[i];
      add_row(work, state, row++, axes + 3 * i, end->weights[1]);
    }
  }
  state->misses[2 * number] = length(state->error + begin, (int)(straight - begin));
  state->misses[2 * number + 1] = length(state->error + straight, (int)(row - straight));
  for (Py_ssize_t i = begin; i < row; i++) {
    state->error[i] = state->error[i] * end->weights[i >= straight];
  }
  return row;
}

static void look_at(Work* work, State* state, const Pose* goals) {
  place_links(work, state);
  for (Py_ssize_t i = 0, row = 0; i < work->p->ends; i++) {
    row = add_rows(work, state, row, i, goals + i);
  }
}


//------------------------------------------ iterations --------------------------------------------

static double sum_of_products(const double* a, const double* b, Py_ssize_t count) {
  double total = 0.0;
  for (Py_ssize_t i = 0; i < count; i++) {
    total += a[i] * b[i];
  }
  return total;
}

/* J^T times a vector. */
static void multiply_transposed(double* found, const double* rows, const double* vector, Py_ssize_t k, Py_ssize_t m) {
  memset(found, 0, (size_t)m * sizeof(double));
  for (Py_ssize_t i = 0; i < k; i++) {
    for (Py_ssize_t j = 0; j < m; j++) {
      found[j] += rows[i * m + j] * vector[i];
    }
  }
}

/* `_solved`: the solution is written over the right side. */
static void solve_equations(double* rows, double* right, Py_ssize_t count) {
  for (Py_ssize_t i = 0; i < count; i++) {
    Py_ssize_t pivot = i;
    for (Py_ssize_t j = i + 1; j < count; j++) {
      pivot = fabs(rows[j * count + i]) > fabs(rows[pivot * count + i]) ? j : pivot;
    }
    double* first = rows + i * count;
    if (pivot != i) {
      double* other = rows + pivot * count;
      for (Py_ssize_t k = i; k < count; k++) {
        double moved = first[k];
        first[k] = other[k], other[k] = moved;
      }
      double moved = right[i];
      right[i] = right[pivot], right[pivot] = moved;
    }
    if (first[i] == 0.0) {
      memset(right, 0, (size_t)count * sizeof(double));
      return;
    }
    for (Py_ssize_t j = i + 1; j < count; j++) {
      double *row = rows + j * count, factor = row[i] / first[i];
      for (Py_ssize_t k = i + 1; k < count; k++) {
        row[k] -= factor * first[k];
      }
      right[j] -= factor * right[i];
    }
  }
  for (Py_ssize_t i = count - 1; i >= 0; i--) {
    double *row = rows + i * count, value = right[i];
    for (Py_ssize_t k = i + 1; k < count; k++) {
      value -= row[k] * right[k];
    }
    right[i] = value / row[i];
  }
}

/* `change`, with the scaled Jacobian. */
static void find_change(Work* work, int method, double damping) {
  const double *error = work->now.error, *rows = work->scaled;
  double *change = work->change, *square = work->square, *right = work->right;
  Py_ssize_t k = work->p->rows, m = work->p->columns;
  if (method == TRANSPOSE) {
    multiply_transposed(change, rows, error, k, m);
    for (Py_ssize_t i = 0; i < k; i++) {
      right[i] = sum_of_products(rows + i * m, change, m);
    }
    double moved = sum_of_products(right, right, k);
    double factor = moved > 0 ? sum_of_products(error, right, k) / moved : 1.0;
    for (Py_ssize_t j = 0; j < m; j++) {
      change[j] *= factor;
    }
    return;
  }
  if (method == ADAPTIVE) {
    damping = 0.5 * sum_of_products(error, error, k) + LEAST_DAMPING;
  }
  for (Py_ssize_t i = 0; i < k; i++) {
    for (Py_ssize_t j = 0; j <= i; j++) {
      square[i * k + j] = square[j * k + i] = sum_of_products(rows + i * m, rows + j * m, m);
    }
    square[i * k + i] += damping;
    right[i] = error[i];
  }
  solve_equations(square, right, k);
  multiply_transposed(change, rows, right, k, m);
}

/* `_limited_change` */
static void find_limited_change(Work* work, int method, double damping) {
  const Problem* p = work->p;
  const double* values = work->now.values;
  Py_ssize_t k = p->rows, m = p->columns;
  memcpy(work->eager, p->eagerness, (size_t)m * sizeof(double));
  for (int is_outside = 1; is_outside;) {
    for (Py_ssize_t i = 0; i < k; i++) {
      for (Py_ssize_t j = 0; j < m; j++) {
        work->scaled[i * m + j] = work->now.jacobian[i * m + j] * work->eager[j];
      }
    }
    find_change(work, method, damping);
    is_outside = 0;
    for (Py_ssize_t j = 0; j < m; j++) {
      work->change[j] *= work->eager[j];
      if ((values[j] <= p->low[j] && work->change[j] < 0) || (values[j] >= p->high[j] && work->change[j] > 0)) {
        work->eager[j] = 0.0;
        is_outside = 1;
      }
    }
  }
}

static int are_within(const Problem* p, const State* state, double share) {
  for (Py_ssize_t i = 0; i < p->ends; i++) {
    if (state->misses[2 * i] > p->end[i].precision[0] * share ||
        state->misses[2 * i + 1] > p->end[i].precision[1] * share) {
      return 0;
    }
  }
  return 1;
}

static double clipped(const Problem* p, Py_ssize_t column, double value) {
  value = value < p->low[column] ? p->low[column] : value;
  return value > p->high[column] ? p->high[column] : value;
}

/* Make the trial the present state; further turns start where the spherical joints are now. */
static void accept(Work* work) {
  const Problem* p = work->p;
  State trial = work->trial;
  for (Py_ssize_t ball = 0; ball < p->balls; ball++) {
    turned(work->now.turns + 4 * ball, p, &trial, ball);
    normalise(work->now.turns + 4 * ball);
    memset(trial.values + p->columns - 3 * p->balls + 3 * ball, 0, 3 * sizeof(double));
  }
  double* turns = trial.turns;
  trial.turns = work->now.turns;
  work->trial = work->now;
  work->trial.turns = turns;
  work->now = trial;
}

/* `InPython.solve`; return the number of states that were looked at. */
static int iterate(Work* work, const Pose* goals, int method, double damping, double stretch, int iterations, int most) {
  const Problem* p = work->p;
  Py_ssize_t k = p->rows, m = p->columns;
  int left = most - 1;
  for (Py_ssize_t j = 0; j < m; j++) {
    work->now.values[j] = clipped(p, j, work->now.values[j]);
  }
  look_at(work, &work->now, goals);
  for (int i = 0; i < iterations && !are_within(p, &work->now, ENOUGH); i++) {
    find_limited_change(work, method, damping);
    double factor = 1.0, square = sum_of_products(work->now.error, work->now.error, k);
    for (Py_ssize_t j = 0; j < m; j++) {
      double share = fabs(work->change[j]) / (stretch * p->steps[j]);
      factor = share > factor ? share : factor;
    }
    for (Py_ssize_t j = 0; j < m; j++) {
      work->change[j] /= factor;
    }
    memcpy(work->trial.turns, work->now.turns, 4 * (size_t)p->balls * sizeof(double));
    int is_better = 0;
    for (int tries = left < HALVINGS ? left : HALVINGS; tries > 0 && !is_better; tries--) {
      left--;
      for (Py_ssize_t j = 0; j < m; j++) {
        work->trial.values[j] = clipped(p, j, work->now.values[j] + work->change[j]);
      }
      look_at(work, &work->trial, goals);
      is_better = sum_of_products(work->trial.error, work->trial.error, k) < square;
      for (Py_ssize_t j = 0; j < m && !is_better; j++) {
        work->change[j] *= 0.5;
      }
    }
    if (!is_better) {
      break;
    }
    accept(work);
    int is_stuck = 1;
    for (Py_ssize_t j = 0; j < m; j++) {
      is_stuck &= !(fabs(work->change[j]) >= STUCK);
    }
    if (is_stuck) {
      break;
    }
  }
  return most - left;
}

static int is_at_limit(const Problem* p, const double* values) {
  for (Py_ssize_t j = 0; j < p->columns; j++) {
    if (values[j] <= p->low[j] || values[j] >= p->high[j]) {
      return 1;
    }
  }
  return 0;
}


//------------------------------------------ random starts -----------------------------------------

/* NumPy's struct of a source of random numbers: numpy/random/bitgen.h */
typedef struct {
  void* state;
  uint64_t (*next_uint64)(void*);
  uint32_t (*next_uint32)(void*);
  double (*next_double)(void*);
  uint64_t (*next_raw)(void*);
} Source;

/* `weighted_length` */
static double weighted_length(const Pose* tip, const Pose* goal, const double* metric) {
  double turn[4], vector[3], way[3], weighted[4];
  turn_between(turn, tip->turn, goal->turn);
  rotation_vector(vector, turn);
  subtract(way, goal->place, tip->place);
  for (int i = 0; i < 3; i++) {
    weighted[i] = metric[i] * way[i];
  }
  weighted[3] = metric[3] * length(vector, 3);
  return length(weighted, 4);
}

static int are_near(Work* work, const Pose* goals, const double* metric, double threshold) {
  place_links(work, &work->now);
  for (Py_ssize_t i = 0; i < work->p->ends; i++) {
    Pose tip;
    carried(&tip, work, work->p->end[i].tip_link, &work->p->end[i].tip);
    if (!(weighted_length(&tip, goals + i, metric) <= threshold)) {
      return 0;
    }
  }
  return 1;
}


//------------------------------------------ Python ------------------------------------------------

typedef struct {
  PyObject* object;
  Py_ssize_t count; /* of numbers */
  int is_written;
} Wanted;

#define MOST_ARRAYS 7

typedef struct {
  Py_buffer views[MOST_ARRAYS];
  int taken;
} Arrays;

static void release(Arrays* arrays) {
  while (arrays->taken) {
    PyBuffer_Release(arrays->views + --arrays->taken);
  }
}

/* Take one more array with items of a format. Return -1 with an exception; `release` in any case. */
static int take(Arrays* arrays, PyObject* object, const char* format, size_t size, int is_written) {
  Py_buffer* view = arrays->views + arrays->taken;
  if (PyObject_GetBuffer(object, view, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (is_written ? PyBUF_WRITABLE : 0)) < 0) {
    return -1;
  }
  arrays->taken++;
  if (view->itemsize != (Py_ssize_t)size || !view->format || strcmp(view->format, format) != 0) {
    PyErr_Format(PyExc_TypeError, "an array of type '%s' is needed", format);
    return -1;
  }
  return 0;
}

static int take_all(Arrays* arrays, const Wanted* wanted, int count) {
  for (int i = 0; i < count; i++) {
    if (take(arrays, wanted[i].object, "d", sizeof(double), wanted[i].is_written) < 0) {
      return -1;
    }
    if (arrays->views[i].len != wanted[i].count * (Py_ssize_t)sizeof(double)) {
      PyErr_SetString(PyExc_ValueError, "an array does not have the size that belongs to the problem");
      return -1;
    }
  }
  return 0;
}

/* The frame of a link as it is, and with the joint at 0: `_frames`. */
static void find_frames(Pose* now, Pose* zero, int32_t kind, const double* present, const double* ball) {
  static const double z[3] = {0.0, 0.0, 1.0};
  const double *axis = present + 3, value = present[6], rest = present[7];
  memcpy(now->place, present, sizeof(now->place));
  *zero = *now;
  if (kind == BALL) {
    memcpy(now->turn, ball, sizeof(now->turn));
    memcpy(zero->turn, ball + 4, sizeof(zero->turn));
    return;
  }
  turn_z_to(now->turn, axis);
  memcpy(zero->turn, now->turn, sizeof(zero->turn));
  if (kind == HINGE) {
    double turn[4];
    about(turn, z, -value);
    multiply(zero->turn, now->turn, turn);
    return;
  }
  for (int i = 0; i < 3; i++) {
    now->place[i] = present[i] + axis[i] * (value - rest);
    zero->place[i] = present[i] + axis[i] * -rest;
  }
}

/* Take over links, and write their frames. Return whether the links fit each other. */
static int set_links(Problem* p, const int32_t* numbers, const double* present, const double* balls, Pose* moved) {
  Py_ssize_t single = p->columns - 3 * p->balls, found = 0;
  for (Py_ssize_t i = 0; i < p->links; i++, numbers += 3, present += 8) {
    Link* link = p->link + i;
    *link = (Link){.before = numbers[0], .kind = numbers[1], .column = numbers[2]};
    int is_ball = link->kind == BALL;
    if (link->before < -1 || link->before >= i || link->kind < HINGE || link->kind > BALL || link->column < 0 ||
        (is_ball ? found == p->balls || link->column < single || (link->column - single) % 3 ||
                     link->column >= p->columns
                 : link->column >= single)) {
      return 0;
    }
    Pose zero;
    find_frames(moved + i, &zero, link->kind, present, balls + 8 * found);
    found += is_ball;
    if (link->before < 0) {
      link->fixed = zero;
    } else {
      see_from(&link->fixed, moved + link->before, &zero);
    }
  }
  return found == p->balls && single >= 0;
}

static void read_pose(Pose* pose, const double* numbers, int32_t link, const Pose* moved) {
  Pose world;
  memcpy(world.place, numbers, sizeof(world.place));
  memcpy(world.turn, numbers + 3, sizeof(world.turn));
  if (link < 0) {
    *pose = world;
  } else {
    see_from(pose, moved + link, &world);
  }
}

static int set_ends(Problem* p, const int32_t* numbers, const double* poses, const Pose* moved) {
  for (Py_ssize_t i = 0; i < p->ends; i++, numbers += 3, poses += 18) {
    End* end = p->end + i;
    *end = (End){.tip_link = numbers[0], .base_link = numbers[1], .constraints = numbers[2]};
    if (end->tip_link < -1 || end->tip_link >= p->links || end->base_link < -1 || end->base_link >= p->links) {
      return 0;
    }
    read_pose(&end->tip, poses, end->tip_link, moved);
    read_pose(&end->base, poses + 7, end->base_link, moved);
    memcpy(end->weights, poses + 14, sizeof(end->weights));
    memcpy(end->precision, poses + 16, sizeof(end->precision));
    end->used = p->used + i * p->columns;
    for (int bit = 0; bit < 3; bit++) {
      p->rows += (end->constraints >> bit) & 1;
    }
    p->rows += (end->constraints & ALPHA_BETA ? 2 : 0) + (end->constraints & GAMMA ? 1 : 0);
  }
  return 1;
}

enum { LINKS, PRESENT, BALLS, ENDS, POSES, USED, BOUNDS, ARRAYS };

/* Copy the arrays of a problem; -1 with an exception if they do not fit each other. */
static int fill(Problem* p, const Py_buffer* views) {
  const Py_ssize_t size = sizeof(double), number = sizeof(int32_t);
  Py_ssize_t l = p->links = views[LINKS].len / (3 * number), e = p->ends = views[ENDS].len / (3 * number);
  Py_ssize_t m = p->columns = views[BOUNDS].len / (4 * size), b = p->balls = views[BALLS].len / (8 * size);
  if (l > MOST || e > MOST || m > MOST || views[LINKS].len != 3 * l * number || views[PRESENT].len != 8 * l * size ||
      views[BALLS].len != 8 * b * size || views[ENDS].len != 3 * e * number || views[POSES].len != 18 * e * size ||
      views[USED].len != e * m || views[BOUNDS].len != 4 * m * size || e == 0) {
    PyErr_SetString(PyExc_ValueError, "the arrays of a problem do not have sizes that fit each other");
    return -1;
  }
  p->link = malloc(((size_t)l + 1) * sizeof(Link));
  p->end = malloc((size_t)e * sizeof(End));
  p->low = malloc((4 * (size_t)m + 1) * sizeof(double));
  p->used = malloc((size_t)(e * m) + 1);
  Pose* moved = malloc(((size_t)l + 1) * sizeof(Pose));
  int fits = -1;
  if (!p->link || !p->end || !p->low || !p->used || !moved) {
    PyErr_NoMemory();
    goto end;
  }
  memcpy(p->low, views[BOUNDS].buf, (size_t)views[BOUNDS].len);
  memcpy(p->used, views[USED].buf, (size_t)views[USED].len);
  p->high = p->low + m, p->steps = p->high + m, p->eagerness = p->steps + m;
  if (!set_links(p, views[LINKS].buf, views[PRESENT].buf, views[BALLS].buf, moved) ||
      !set_ends(p, views[ENDS].buf, views[POSES].buf, moved)) {
    PyErr_SetString(PyExc_ValueError, "links, columns and elements of a problem do not fit each other");
    goto end;
  }
  fits = 0;
end:
  free(moved);
  return fits;
}

static PyObject* make(PyTypeObject* type, PyObject* args, PyObject* keywords) {
  (void)keywords;
  static const char* formats[ARRAYS] = {"i", "d", "d", "i", "d", "?", "d"};
  PyObject* a[ARRAYS];
  if (!PyArg_ParseTuple(args, "OOOOOOO", a, a + 1, a + 2, a + 3, a + 4, a + 5, a + 6)) {
    return NULL;
  }
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  Problem* p = (Problem*)allocate(type, 0); /* zeroed */
  if (!p) {
    return NULL;
  }
  Arrays arrays = {.taken = 0};
  int is_made = 1;
  for (int i = 0; i < ARRAYS && is_made; i++) {
    size_t size = *formats[i] == 'd' ? sizeof(double) : *formats[i] == 'i' ? sizeof(int32_t) : 1;
    is_made = take(&arrays, a[i], formats[i], size, 0) == 0;
  }
  is_made = is_made && fill(p, arrays.views) == 0;
  release(&arrays);
  if (!is_made) {
    Py_DECREF(p);
    return NULL;
  }
  return (PyObject*)p;
}

static void forget(PyObject* self) {
  Problem* p = (Problem*)self;
  PyTypeObject* type = Py_TYPE(self);
  free(p->link), free(p->end), free(p->low), free(p->used);
  freefunc free_object = (freefunc)PyType_GetSlot(type, Py_tp_free);
  free_object(self);
  Py_DECREF(type);
}

/* Take the arrays of a call and give it memory; NULL with an exception. */
static void* begin(Work* work, const Problem* p, Arrays* arrays, const Wanted* wanted, int count) {
  if (take_all(arrays, wanted, count) < 0) {
    return NULL;
  }
  void* memory = furnish(work, p);
  if (!memory) {
    PyErr_NoMemory();
  }
  return memory;
}

static void copy(double* to, const Py_buffer* view) { memcpy(to, view->buf, (size_t)view->len); }
static void give(const Py_buffer* view, const double* from) { memcpy(view->buf, from, (size_t)view->len); }

PyDoc_STRVAR(solve_doc, "solve(values, turns, goals, method, damping, stretch, iterations, most_looks)\n\n"
"Do what `form.LeastSquares.solve` says.");

static PyObject* solve(PyObject* self, PyObject* args) {
  const Problem* p = (const Problem*)self;
  PyObject* a[3];
  int method, iterations, most;
  double damping, stretch;
  if (!PyArg_ParseTuple(args, "OOOiddii", a, a + 1, a + 2, &method, &damping, &stretch, &iterations, &most)) {
    return NULL;
  }
  const Wanted wanted[] = {{a[0], p->columns, 1}, {a[1], 4 * p->balls, 1}, {a[2], 7 * p->ends, 0}};
  Arrays arrays = {.taken = 0};
  Work work;
  PyObject* found = NULL;
  void* memory = begin(&work, p, &arrays, wanted, 3);
  if (memory) {
    const Pose* goals = arrays.views[2].buf;
    int looks;
    copy(work.now.values, arrays.views), copy(work.now.turns, arrays.views + 1);
    Py_BEGIN_ALLOW_THREADS
    looks = iterate(&work, goals, method, damping, stretch, iterations, most);
    Py_END_ALLOW_THREADS
    give(arrays.views, work.now.values), give(arrays.views + 1, work.now.turns);
    double worst[2] = {0.0, 0.0};
    for (Py_ssize_t i = 0; i < 2 * p->ends; i++) {
      const double miss = work.now.misses[i];
      worst[i % 2] = i < 2 || miss > worst[i % 2] ? miss : worst[i % 2];
    }
    found = Py_BuildValue("ddNNi", worst[0], worst[1], PyBool_FromLong(are_within(p, &work.now, 1.0)),
                          PyBool_FromLong(is_at_limit(p, work.now.values)), looks);
  }
  free(memory);
  release(&arrays);
  return found;
}

PyDoc_STRVAR(look_doc, "look(values, turns, goals, error, jacobian)\n\nDo what `form.LeastSquares.look` says.");

static PyObject* look(PyObject* self, PyObject* args) {
  const Problem* p = (const Problem*)self;
  PyObject* a[5];
  if (!PyArg_ParseTuple(args, "OOOOO", a, a + 1, a + 2, a + 3, a + 4)) {
    return NULL;
  }
  const Wanted wanted[] = {
    {a[0], p->columns, 0}, {a[1], 4 * p->balls, 0}, {a[2], 7 * p->ends, 0}, {a[3], p->rows, 1},
    {a[4], p->rows * p->columns, 1},
  };
  Arrays arrays = {.taken = 0};
  Work work;
  void* memory = begin(&work, p, &arrays, wanted, 5);
  if (memory) {
    copy(work.now.values, arrays.views), copy(work.now.turns, arrays.views + 1);
    look_at(&work, &work.now, arrays.views[2].buf);
    give(arrays.views + 3, work.now.error), give(arrays.views + 4, work.now.jacobian);
  }
  free(memory);
  release(&arrays);
  return memory ? Py_NewRef(Py_None) : NULL;
}

PyDoc_STRVAR(tips_doc, "tips(values, turns, poses)\n\nDo what `form.LeastSquares.tips` says.");

static PyObject* tips(PyObject* self, PyObject* args) {
  const Problem* p = (const Problem*)self;
  PyObject* a[3];
  if (!PyArg_ParseTuple(args, "OOO", a, a + 1, a + 2)) {
    return NULL;
  }
  const Wanted wanted[] = {{a[0], p->columns, 0}, {a[1], 4 * p->balls, 0}, {a[2], 7 * p->ends, 1}};
  Arrays arrays = {.taken = 0};
  Work work;
  void* memory = begin(&work, p, &arrays, wanted, 3);
  if (memory) {
    copy(work.now.values, arrays.views), copy(work.now.turns, arrays.views + 1);
    place_links(&work, &work.now);
    Pose* poses = arrays.views[2].buf;
    for (Py_ssize_t i = 0; i < p->ends; i++) {
      carried(poses + i, &work, p->end[i].tip_link, &p->end[i].tip);
    }
  }
  free(memory);
  release(&arrays);
  return memory ? Py_NewRef(Py_None) : NULL;
}

/* The source of a NumPy generator; it lives as long as the generator. NULL with an exception. */
static Source* source_of(PyObject* random) {
  PyObject* generator = PyObject_GetAttrString(random, "bit_generator");
  PyObject* capsule = generator ? PyObject_GetAttrString(generator, "capsule") : NULL;
  Source* source = capsule ? PyCapsule_GetPointer(capsule, "BitGenerator") : NULL;
  Py_XDECREF(capsule);
  Py_XDECREF(generator);
  return source;
}

PyDoc_STRVAR(sample_doc, "sample(random, low, extent, goals, metric, threshold, most, values)\n\n"
"Do what `form.LeastSquares.sample` says.");

static PyObject* sample(PyObject* self, PyObject* args) {
  const Problem* p = (const Problem*)self;
  PyObject *random, *a[4];
  double metric[4], threshold;
  int most, number = 0, is_near = 0;
  if (!PyArg_ParseTuple(args, "OOOO(dddd)diO", &random, a, a + 1, a + 2, metric, metric + 1, metric + 2, metric + 3,
                        &threshold, &most, a + 3)) {
    return NULL;
  }
  if (p->balls) {
    PyErr_SetString(PyExc_ValueError, "samples have no spherical joints");
    return NULL;
  }
  Py_ssize_t m = p->columns;
  const Wanted wanted[] = {{a[0], m, 0}, {a[1], m, 0}, {a[2], 7 * p->ends, 0}, {a[3], m, 1}};
  Arrays arrays = {.taken = 0};
  Work work;
  PyObject* found = NULL;
  Source* source = source_of(random);
  void* memory = source ? begin(&work, p, &arrays, wanted, 4) : NULL;
  if (memory) {
    const double *low = arrays.views[0].buf, *extent = arrays.views[1].buf;
    const Pose* goals = arrays.views[2].buf;
    Py_BEGIN_ALLOW_THREADS
    while (number < most && !is_near) {
      number++;
      for (Py_ssize_t j = 0; j < m; j++) {
        work.now.values[j] = low[j] + extent[j] * source->next_double(source->state);
      }
      is_near = are_near(&work, goals, metric, threshold);
    }
    Py_END_ALLOW_THREADS
    if (number) {
      give(arrays.views + 3, work.now.values);
    }
    found = Py_BuildValue("iN", number, PyBool_FromLong(is_near));
  }
  free(memory);
  release(&arrays);
  return found;
}

static PyMethodDef methods[] = {
  {"solve", solve, METH_VARARGS, solve_doc},
  {"look", look, METH_VARARGS, look_doc},
  {"tips", tips, METH_VARARGS, tips_doc},
  {"sample", sample, METH_VARARGS, sample_doc},
  {NULL, NULL, 0, NULL},
};

static PyMemberDef members[] = {
  {"rows", T_PYSSIZET, offsetof(Problem, rows), READONLY, NULL},
  {NULL, 0, 0, 0, NULL},
};

static PyType_Slot slots[] = {
  {Py_tp_new, make}, {Py_tp_dealloc, forget}, {Py_tp_methods, methods}, {Py_tp_members, members}, {0, NULL},
};

static PyType_Spec spec = {
  "simx_server.kinematics.least_squares.native._least_squares.LeastSquares", sizeof(Problem), 0, Py_TPFLAGS_DEFAULT, slots,
};

static struct PyModuleDef definition = {
  PyModuleDef_HEAD_INIT, "_least_squares", "Inverse kinematics, compiled.", -1, NULL, NULL, NULL, NULL, NULL,
};

#ifndef SOURCE_HASH
#define SOURCE_HASH ""
#endif

PyMODINIT_FUNC PyInit__least_squares(void) {
  PyObject* module = PyModule_Create(&definition);
  PyObject* type = module ? PyType_FromSpec(&spec) : NULL;
  if (!type || PyModule_AddObjectRef(module, "LeastSquares", type) < 0 ||
      PyModule_AddStringConstant(module, "SOURCE_HASH", SOURCE_HASH) < 0) {
    Py_XDECREF(type);
    Py_XDECREF(module);
    return NULL;
  }
  Py_DECREF(type);
  return module;
}
