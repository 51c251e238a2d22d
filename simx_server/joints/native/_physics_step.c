/* The physics steps of one simulation step: motors, controllers and corrections of contacts around MuJoCo's two halves.

   It does what the classes of ../stepping/ do, operation by operation and in the same order, so both give the same
   numbers bit for bit: no sum is reordered, and the build forbids fused multiplications (-ffp-contract=off). A formula
   that changes here changes there; tests/server/joints/test_compiled_steps.py holds both equal.

   The columns below are NumPy arrays of these classes, shared by the buffer protocol: a target that Python writes is
   read here in the next physics step, and the memory of a controller is the same in both forms. Every length and every
   index is checked once, when an object is made; the model of an object never changes its sizes.

   MuJoCo is the library that the mujoco package has loaded: this file links to none and gets the addresses of a few
   functions. Its structs depend on the version, so the caller compares HEADER with the running one. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L
#endif
#include <Python.h>
#include <structmember.h>

#include <math.h>
#include <setjmp.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <mujoco/mujoco.h>

#include "physics_step.h"

#define PI 3.141592653589793

/* as in ../stepping: separation.py, sliding.py, grip.py, noslip.py and ../servo.py */
#define DEEP 0.01
#define FASTEST 1.0
#define SLIDES 1e-2
#define TURNS 1e-2
#define IMMOBILE 1e-6
#define MOST_VELOCITY 1e4
#define LEAST_FORCE 1e-12

#define DAMPING 1 /* column of efc_KBIP */


//------------------------------------------ MuJoCo ------------------------------------------------

/* The functions, by their addresses in the loaded library. */
static struct {
  void (*step)(const mjModel*, mjData*);
  void (*step1)(const mjModel*, mjData*);
  void (*step2)(const mjModel*, mjData*);
  void (*mulJacVec)(const mjModel*, const mjData*, mjtNum*, const mjtNum*);
  void (*solveM)(const mjModel*, mjData*, mjtNum*, const mjtNum*, int);
  int (*isSparse)(const mjModel*);
  void (*kinematics)(const mjModel*, mjData*);
  void (*comPos)(const mjModel*, mjData*);
  void (*camlight)(const mjModel*, mjData*);
  void (*flex)(const mjModel*, mjData*);
  void (*tendon)(const mjModel*, mjData*);
  mjfLogHandler (*setThreadsHandler)(mjfLogHandler);
  mjfLogHandler (*getHandler)(void);
} mj;

static PyObject *model_type, *data_type, *fatal_error, *no_room;

/* MuJoCo's errors do not return to their caller. As in its Python package, they jump to where the call began. */
static _Thread_local jmp_buf* escape;
static _Thread_local char problem[TEXT_SIZE];

/* Takes the warnings of this thread, in place of the process' handler; NULL: that handler gets them. */
static _Thread_local PhysicsReport* listener;

static void copy_text(char text[TEXT_SIZE], const char source[TEXT_SIZE]) {
  memcpy(text, source, TEXT_SIZE);
  text[TEXT_SIZE - 1] = 0;
}

static void on_message(const mjLogMessage* message) {
  if (message->level == mjLOG_ERROR && escape) {
    copy_text(problem, message->subject);
    longjmp(*escape, 1);
  }
  if (message->level == mjLOG_WARNING && listener) {
    if (listener->warning_count < MOST_WARNINGS) {
      copy_text(listener->warnings[listener->warning_count++], message->subject);
    }
    return;
  }
  mjfLogHandler handler = mj.getHandler();
  if (handler) {
    handler(message);
  }
}


//------------------------------------------ columns -----------------------------------------------

enum {
  POSITION_TARGET, POSITION_GAIN, POSITION_LIMIT, POSITION_INTEGRAL, POSITION_DERIVATIVE, POSITION_SUM, POSITION_LAST,
  POSITION_CTRL, POSITION_GEAR, POSITION_CYCLIC,
  POSITION_QPOS, POSITION_TENDON, POSITION_OFFSET,
  LED_PLACE, LED_QPOS, LED_FACTOR, LED_SHIFT, LED_LOW, LED_HIGH,
  SPRING_QPOS, SPRING_CTRL, SPRING_GEAR, SPRING_TARGET,
  STIFF_JOINT, STIFF_QPOS, STIFF_DOF, STIFF_CTRL, STIFF_GEAR, STIFF_CYCLIC, STIFF_OFFSET, STIFF_FRICTION,
  STIFF_TARGET, STIFF_K, STIFF_C, STIFF_FORCE, STIFF_VELOCITY,
  MOTOR_CTRL, MOTOR_OUT, MOTOR_GEAR, MOTOR_ROW, MOTOR_DOF, MOTOR_TENDON,
  FRICTION_PLACE, FRICTION_ACTUATOR, FRICTION_LOSS,
  STILL_QPOS, STILL_VALUE, STILL_DOF,
  MOVING_QPOS, MOVING_DOF, MOVING_VALUE, MOVING_RATE, MOVING_LOW, MOVING_HIGH,
  REWOUND_QPOS, REWOUND_START,
  FOLLOWER_QPOS, FOLLOWER_DOF, FOLLOWER_LEAD_QPOS, FOLLOWER_LEAD_DOF, FOLLOWER_FACTOR, FOLLOWER_SHIFT, FOLLOWER_LOW,
  FOLLOWER_HIGH,
  GEOM_BASE, MEAN_FORCE, MEAN_SENSED,
  COLUMNS
};

/* What an index counts. */
enum { NUMBER, OF_QPOS, OF_DOF, OF_CTRL, OF_OUT, OF_TENDON, OF_JOINT, OF_ACTUATOR, OF_POSITION, OF_MOTOR, OF_ANY };

static const struct {
  const char* name;
  int indexes; /* NUMBER: the column has doubles */
  int like;    /* the column whose length it has; its own number: any length */
} columns[COLUMNS] = {
  {"position.target", NUMBER, POSITION_TARGET},
  {"position.gain", NUMBER, POSITION_TARGET},
  {"position.limit", NUMBER, POSITION_TARGET},
  {"position.integral", NUMBER, POSITION_TARGET},
  {"position.derivative", NUMBER, POSITION_TARGET},
  {"position.sum", NUMBER, POSITION_TARGET},
  {"position.last", NUMBER, POSITION_TARGET},
  {"position.ctrl", OF_CTRL, POSITION_TARGET},
  {"position.gear", NUMBER, POSITION_TARGET},
  {"position.cyclic", OF_ANY, POSITION_TARGET},
  {"position.qpos", OF_QPOS, POSITION_QPOS},
  {"position.tendon", OF_TENDON, POSITION_TENDON},
  {"position.offset", NUMBER, POSITION_TENDON},
  {"led.place", OF_POSITION, LED_PLACE},
  {"led.qpos", OF_QPOS, LED_PLACE},
  {"led.factor", NUMBER, LED_PLACE},
  {"led.shift", NUMBER, LED_PLACE},
  {"led.low", NUMBER, LED_PLACE},
  {"led.high", NUMBER, LED_PLACE},
  {"spring.qpos", OF_QPOS, SPRING_QPOS},
  {"spring.ctrl", OF_CTRL, SPRING_QPOS},
  {"spring.gear", NUMBER, SPRING_QPOS},
  {"spring.target", NUMBER, SPRING_QPOS},
  {"stiff.joint", OF_JOINT, STIFF_JOINT},
  {"stiff.qpos", OF_QPOS, STIFF_JOINT},
  {"stiff.dof", OF_DOF, STIFF_JOINT},
  {"stiff.ctrl", OF_CTRL, STIFF_JOINT},
  {"stiff.gear", NUMBER, STIFF_JOINT},
  {"stiff.cyclic", OF_ANY, STIFF_JOINT},
  {"stiff.offset", NUMBER, STIFF_JOINT},
  {"stiff.friction", NUMBER, STIFF_JOINT},
  {"stiff.target", NUMBER, STIFF_JOINT},
  {"stiff.k", NUMBER, STIFF_JOINT},
  {"stiff.c", NUMBER, STIFF_JOINT},
  {"stiff.force", NUMBER, STIFF_JOINT},
  {"stiff.velocity", NUMBER, STIFF_JOINT},
  {"motor.ctrl", OF_CTRL, MOTOR_CTRL},
  {"motor.out", OF_OUT, MOTOR_CTRL},
  {"motor.gear", NUMBER, MOTOR_CTRL},
  {"motor.row", OF_ANY, MOTOR_CTRL},
  {"motor.dof", OF_DOF, MOTOR_DOF},
  {"motor.tendon", OF_TENDON, MOTOR_TENDON},
  {"friction.place", OF_MOTOR, FRICTION_PLACE},
  {"friction.actuator", OF_ACTUATOR, FRICTION_PLACE},
  {"friction.loss", NUMBER, FRICTION_PLACE},
  {"still.qpos", OF_QPOS, STILL_QPOS},
  {"still.value", NUMBER, STILL_QPOS},
  {"still.dof", OF_DOF, STILL_DOF},
  {"moving.qpos", OF_QPOS, MOVING_QPOS},
  {"moving.dof", OF_DOF, MOVING_QPOS},
  {"moving.value", NUMBER, MOVING_QPOS},
  {"moving.rate", NUMBER, MOVING_QPOS},
  {"moving.low", NUMBER, MOVING_QPOS},
  {"moving.high", NUMBER, MOVING_QPOS},
  {"rewound.qpos", OF_QPOS, REWOUND_QPOS},
  {"rewound.start", NUMBER, REWOUND_QPOS},
  {"follower.qpos", OF_QPOS, FOLLOWER_QPOS},
  {"follower.dof", OF_DOF, FOLLOWER_QPOS},
  {"follower.lead_qpos", OF_QPOS, FOLLOWER_QPOS},
  {"follower.lead_dof", OF_DOF, FOLLOWER_QPOS},
  {"follower.factor", NUMBER, FOLLOWER_QPOS},
  {"follower.shift", NUMBER, FOLLOWER_QPOS},
  {"follower.low", NUMBER, FOLLOWER_QPOS},
  {"follower.high", NUMBER, FOLLOWER_QPOS},
  {"geom.base", OF_ANY, GEOM_BASE},
  {"mean.force", NUMBER, MEAN_FORCE},
  {"mean.sensed", NUMBER, MEAN_SENSED},
};

typedef struct {
  PyObject_HEAD
  PyObject *model, *data; /* they own m and d */
  mjModel* m;
  mjData* d;
  Py_buffer views[COLUMNS];
  PyObject *grip, *is_immobile; /* Python functions for the rare cases, see below */
  int rows_in_all;              /* frictions of the model: rows of constraints when nothing sleeps */
  int has_terms;                /* of integral or derivative */
  int has_cells;                /* force sensors, whose values are averaged */
  int is_elliptic;
  int is_running;

  /* of the motors, in this physics step */
  double* wanted;
  int* rows;
  char* is_stuck;
  int suspended; /* iterations of the noslip pass, while it is left out */

  double* scratch;
  size_t scratch_size;

  /* of the end of the last simulation step */
  char is_finite;
  char has_deep_contacts;

  /* of the last run */
  char has_diverged; /* MuJoCo has found bad numbers */
  double seconds;

  PyThreadState* thread; /* while the interpreter's lock is released */
  Py_ssize_t made;
} PhysicsStep;

static double* real(const PhysicsStep* s, int column) {
  return (double*)s->views[column].buf;
}

static const Py_ssize_t* index_of(const PhysicsStep* s, int column) {
  return (const Py_ssize_t*)s->views[column].buf;
}

static Py_ssize_t length(const PhysicsStep* s, int column) {
  return s->views[column].len / (Py_ssize_t)sizeof(double);
}

/* Return room for this many numbers until the next call; jumps to the end of the run without memory. */
static double* room(PhysicsStep* s, size_t count) {
  if (count > s->scratch_size) {
    double* larger = realloc(s->scratch, count * sizeof(double));
    if (!larger) {
      strcpy(problem, "no memory for the contacts");
      longjmp(*escape, 1);
    }
    s->scratch = larger;
    s->scratch_size = count;
  }
  return s->scratch;
}


//------------------------------------------ NumPy's and Python's arithmetic -----------------------

/* np.minimum, np.maximum, np.clip: nan wins */
static double minimum(double a, double b) { return (a < b || isnan(a)) ? a : b; }
static double maximum(double a, double b) { return (a > b || isnan(a)) ? a : b; }
static double clip(double x, double low, double high) { return minimum(maximum(x, low), high); }

/* np.remainder */
static double modulo(double a, double b) {
  double rest = fmod(a, b);
  if (rest == 0) {
    return copysign(0, b);
  }
  return (b < 0) != (rest < 0) ? rest + b : rest;
}

/* An error of a joint that turns the short way round. */
static double short_way(double error) { return modulo(error + PI, 2 * PI) - PI; }

static double sign(double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : x; }


//------------------------------------------ before a physics step ---------------------------------

/* position_control.py */
static void control_positions(PhysicsStep* s) {
  mjData* d = s->d;
  double* target = real(s, POSITION_TARGET);
  const Py_ssize_t* led = index_of(s, LED_PLACE);
  for (Py_ssize_t i = 0; i < length(s, LED_PLACE); i++) {
    double wanted = d->qpos[index_of(s, LED_QPOS)[i]] * real(s, LED_FACTOR)[i] + real(s, LED_SHIFT)[i];
    target[led[i]] = clip(wanted, real(s, LED_LOW)[i], real(s, LED_HIGH)[i]);
  }
  const double *gain = real(s, POSITION_GAIN), *limit = real(s, POSITION_LIMIT), *gear = real(s, POSITION_GEAR);
  const Py_ssize_t *ctrl = index_of(s, POSITION_CTRL), *cyclic = index_of(s, POSITION_CYCLIC);
  const Py_ssize_t *qpos = index_of(s, POSITION_QPOS), *tendon = index_of(s, POSITION_TENDON);
  Py_ssize_t joints = length(s, POSITION_QPOS), count = length(s, POSITION_TARGET);
  for (Py_ssize_t i = 0; i < count; i++) {
    Py_ssize_t t = i - joints;
    double position = t < 0 ? d->qpos[qpos[i]] : d->ten_length[tendon[t]] + real(s, POSITION_OFFSET)[t];
    double error = target[i] - position;
    if (cyclic[i]) {
      error = short_way(error);
    }
    double command = error * gain[i];
    if (s->has_terms) {
      double *sum = real(s, POSITION_SUM), *last = real(s, POSITION_LAST);
      sum[i] = sum[i] + error * real(s, POSITION_INTEGRAL)[i];
      double change = isnan(last[i]) ? 0.0 : error - last[i];
      command = command + (sum[i] + change * real(s, POSITION_DERIVATIVE)[i]);
      last[i] = error;
    }
    command = maximum(minimum(command, limit[i]), -limit[i]);
    d->ctrl[ctrl[i]] = command * gear[i];
  }
}

/* cyclic_springs.py */
static void control_springs(PhysicsStep* s) {
  mjData* d = s->d;
  for (Py_ssize_t i = 0; i < length(s, SPRING_QPOS); i++) {
    double position = d->qpos[index_of(s, SPRING_QPOS)[i]];
    double error = short_way(real(s, SPRING_TARGET)[i] - position);
    d->ctrl[index_of(s, SPRING_CTRL)[i]] = (position + error) * real(s, SPRING_GEAR)[i];
  }
}

/* stiff_springs.py, with servo.py's write_motor_force */
static void control_stiff_springs(PhysicsStep* s) {
  mjModel* m = s->m;
  mjData* d = s->d;
  for (Py_ssize_t i = 0; i < length(s, STIFF_JOINT); i++) {
    Py_ssize_t joint = index_of(s, STIFF_JOINT)[i], dof = index_of(s, STIFF_DOF)[i];
    double error = real(s, STIFF_TARGET)[i] - real(s, STIFF_OFFSET)[i] - d->qpos[index_of(s, STIFF_QPOS)[i]];
    if (index_of(s, STIFF_CYCLIC)[i] && isfinite(error)) {
      error = remainder(error, 2 * PI);
    }
    double force = real(s, STIFF_K)[i] * error - real(s, STIFF_C)[i] * d->qvel[dof];
    double most = lesser(fabs(real(s, STIFF_VELOCITY)[i]), MOST_VELOCITY);
    d->ctrl[index_of(s, STIFF_CTRL)[i]] = clip(error / m->opt.timestep, -most, most) * real(s, STIFF_GEAR)[i];

    double limit = greater(lesser(fabs(force), real(s, STIFF_FORCE)[i]), real(s, STIFF_FRICTION)[i]);
    if (m->jnt_actfrclimited[joint]) {
      const mjtNum* range = m->jnt_actfrcrange + 2 * joint;
      limit = lesser(limit, maximum(fabs(range[0]), fabs(range[1])));
    }
    m->dof_frictionloss[dof] = greater(limit, LEAST_FORCE);
  }
}


//------------------------------------------ motors: motors.py -------------------------------------

/* Let the friction of the joints themselves act against the commanded motion. */
static void resist(PhysicsStep* s) {
  mjModel* m = s->m;
  Py_ssize_t joints = length(s, MOTOR_DOF);
  memset(s->is_stuck, 0, (size_t)length(s, MOTOR_CTRL));
  for (Py_ssize_t i = 0; i < length(s, FRICTION_PLACE); i++) {
    Py_ssize_t place = index_of(s, FRICTION_PLACE)[i], t = place - joints;
    double most = t < 0 ? m->dof_frictionloss[index_of(s, MOTOR_DOF)[place]]
                        : m->tendon_frictionloss[index_of(s, MOTOR_TENDON)[t]];
    double loss = real(s, FRICTION_LOSS)[i], gear = real(s, MOTOR_GEAR)[place];
    double resistance = loss * sign(s->d->ctrl[index_of(s, MOTOR_CTRL)[place]] * gear);
    if (most <= loss) {
      s->is_stuck[place] = 1;
      resistance = 0.0;
    }
    m->actuator_biasprm[index_of(s, FRICTION_ACTUATOR)[i] * mjNBIAS] = -resistance / gear;
  }
}

/* Return the row of a motor's constraint where rows of sleeping bodies are missing; -1: there is none. */
static int search_row(const PhysicsStep* s, Py_ssize_t motor) {
  const mjData* d = s->d;
  Py_ssize_t t = motor - length(s, MOTOR_DOF);
  int type = t < 0 ? mjCNSTR_FRICTION_DOF : mjCNSTR_FRICTION_TENDON;
  Py_ssize_t id = t < 0 ? index_of(s, MOTOR_DOF)[motor] : index_of(s, MOTOR_TENDON)[t];
  for (int row = d->ne; row < d->ne + d->nf; row++) {
    if (d->efc_type[row] == type && d->efc_id[row] == id) {
      return row;
    }
  }
  return -1;
}

/* Write the reference accelerations of all motors; return 0 if one has no constraint. */
static int command_motors(PhysicsStep* s) {
  mjData* d = s->d;
  const double* gear = real(s, MOTOR_GEAR);
  const Py_ssize_t *ctrl = index_of(s, MOTOR_CTRL), *dof = index_of(s, MOTOR_DOF), *tendon = index_of(s, MOTOR_TENDON);
  Py_ssize_t joints = length(s, MOTOR_DOF), count = length(s, MOTOR_CTRL);
  double rate = 1.0 / s->m->opt.timestep;
  for (Py_ssize_t i = 0; i < count; i++) {
    Py_ssize_t t = i - joints;
    double command = s->is_stuck[i] ? 0.0 : d->ctrl[ctrl[i]] / gear[i];
    s->wanted[i] = (command - (t < 0 ? d->qvel[dof[i]] : d->ten_velocity[tendon[t]])) * rate;
    int row = d->nf == s->rows_in_all ? d->ne + (int)index_of(s, MOTOR_ROW)[i] : search_row(s, i);
    if (row < 0 || row >= d->nefc) {
      return 0;
    }
    s->rows[i] = row;
  }
  for (Py_ssize_t i = 0; i < count; i++) {
    d->efc_aref[s->rows[i]] = s->wanted[i];
  }
  return 1;
}

/* Write the forces where MuJoCo keeps those of actuators. */
static void report_motors(PhysicsStep* s) {
  for (Py_ssize_t i = 0; i < length(s, MOTOR_CTRL); i++) {
    s->d->actuator_force[index_of(s, MOTOR_OUT)[i]] = s->d->efc_force[s->rows[i]] / real(s, MOTOR_GEAR)[i];
  }
}


//------------------------------------------ contacts, within a physics step -----------------------

/* NumPy counts -1, the geom of a flex, from the end. */
static int geom_of(const mjModel* m, const mjContact* contact, int side) {
  int geom = contact->geom[side];
  return geom < 0 ? geom + (int)m->ngeom : geom;
}

static int weld_of(const mjModel* m, const mjContact* contact, int side) {
  return m->body_weldid[m->geom_bodyid[geom_of(m, contact, side)]];
}

/* separation.py */
static int has_deep_contacts(const mjData* d) {
  int found = 0;
  for (int i = 0; i < d->ncon; i++) {
    if (isnan(d->contact[i].dist)) {
      return 0;
    }
    found |= d->contact[i].dist < -DEEP;
  }
  return found;
}

static void limit_separation(const mjModel* m, mjData* d) {
  if (!has_deep_contacts(d)) {
    return;
  }
  for (int i = 0; i < d->ncon; i++) {
    const mjContact* contact = d->contact + i;
    int first = contact->efc_address;
    if (!(contact->dist < -DEEP) || first < 0) {
      continue;
    }
    int edges = m->opt.cone == mjCONE_PYRAMIDAL && contact->dim > 1 ? 2 * (contact->dim - 1) : 1;
    for (int row = first; row < first + edges; row++) {
      double speed = d->efc_vel[row];
      double damping = -d->efc_KBIP[4 * row + DAMPING] * speed;
      double most = maximum(damping, (FASTEST - speed) / m->opt.timestep);
      d->efc_aref[row] = minimum(d->efc_aref[row], most);
    }
  }
}

/* sliding.py */
static void keep_down(PhysicsStep* s) {
  const mjModel* m = s->m;
  mjData* d = s->d;
  if (!d->ncon) {
    return;
  }
  int slides = 0;
  for (int row = d->ne + d->nf; row < d->nefc && !slides; row++) {
    slides = !(fabs(d->efc_vel[row]) < SLIDES);
  }
  if (!slides) {
    return;
  }
  double* acceleration = NULL;
  for (int i = 0; i < d->ncon; i++) {
    const mjContact* contact = d->contact + i;
    int first = contact->efc_address;
    if (first < 0 || contact->dim < 3 || (weld_of(m, contact, 0) && weld_of(m, contact, 1))) {
      continue;
    }
    const double *damping = d->efc_KBIP + 4 * (first + 1) + DAMPING, *wanted = d->efc_aref + first + 1;
    if (!(maximum(maximum(fabs(wanted[0]), fabs(wanted[1])), 0.0) > SLIDES * damping[0])) {
      continue;
    }
    if (!acceleration) {
      acceleration = room(s, (size_t)d->nefc);
      mj.mulJacVec(m, d, acceleration, d->qacc_warmstart);
    }
    double lift = 0.0;
    for (int k = 0; k < 2; k++) {
      double missed = acceleration[first + 1 + k] * (1.0 - damping[4 * k] * m->opt.timestep) - wanted[k];
      double part = contact->friction[k] * missed;
      lift += part * part;
    }
    d->efc_aref[first] -= sqrt(lift);
  }
}

/* Call a Python function with model and data; returns -1 with an exception, else whether the result is true. */
static int ask(PhysicsStep* s, PyObject* function) {
  PyEval_RestoreThread(s->thread);
  PyObject* answer = PyObject_CallFunctionObjArgs(function, s->model, s->data, NULL);
  int truth = answer ? PyObject_IsTrue(answer) : -1;
  Py_XDECREF(answer);
  s->thread = PyEval_SaveThread();
  mj.setThreadsHandler(on_message); /* the mujoco package has its own while it works */
  return truth;
}

/* grip.py; returns 0 with an exception. Where bodies turn, its sums are NumPy's, whose order is not known here. */
static int grip(PhysicsStep* s) {
  const mjModel* m = s->m;
  mjData* d = s->d;
  if (!d->ncon || !s->is_elliptic) {
    return 1;
  }
  int found = 0, turns = 0, is_finite = 1;
  for (int i = 0; i < d->ncon; i++) {
    const mjContact* contact = d->contact + i;
    int first = contact->efc_address;
    if (first < 0 || contact->dim <= 1 || weld_of(m, contact, 0) <= 0 || weld_of(m, contact, 1) <= 0) {
      continue;
    }
    found = 1;
    for (int side = 0; side < 2; side++) {
      const mjtNum* velocity = d->cvel + 6 * m->geom_bodyid[geom_of(m, contact, side)];
      for (int k = 0; k < 3; k++) {
        turns |= fabs(velocity[k]) > TURNS;
        is_finite &= !isnan(velocity[k]);
      }
    }
  }
  if (turns && is_finite) {
    return ask(s, s->grip) >= 0;
  }
  for (int i = 0; found && i < d->ncon; i++) {
    const mjContact* contact = d->contact + i;
    int first = contact->efc_address;
    if (first < 0 || contact->dim <= 1 || weld_of(m, contact, 0) <= 0 || weld_of(m, contact, 1) <= 0) {
      continue;
    }
    for (int k = 1; k < 3; k++) {
      d->efc_aref[first + k] = d->efc_vel[first + k] / -m->opt.timestep;
    }
  }
  return 1;
}

/* noslip.py: whether the two bodies of this contact cannot move along some friction; -1: too close to say. */
static int cannot_move(PhysicsStep* s, int first) {
  const mjModel* m = s->m;
  const mjData* d = s->d;
  size_t nv = (size_t)m->nv;
  double *jacobian = room(s, 4 * nv), *accelerated = jacobian + 2 * nv;
  if (mj.isSparse(m)) {
    memset(jacobian, 0, 2 * nv * sizeof(double));
    for (int k = 0; k < 2; k++) {
      int row = first + 1 + k, start = d->efc_J_rowadr[row];
      for (int e = start; e < start + d->efc_J_rownnz[row]; e++) {
        jacobian[(size_t)k * nv + (size_t)d->efc_J_colind[e]] = d->efc_J[e];
      }
    }
  } else {
    memcpy(jacobian, d->efc_J + (size_t)(first + 1) * nv, 2 * nv * sizeof(double));
  }
  mj.solveM(m, s->d, accelerated, jacobian, 2);
  double mobility[2][2] = {{0, 0}, {0, 0}}, size = 0;
  for (size_t i = 0; i < 2; i++) {
    for (size_t j = 0; j < 2; j++) {
      for (size_t k = 0; k < nv; k++) {
        double product = jacobian[i * nv + k] * accelerated[j * nv + k];
        mobility[i][j] += product;
        size += fabs(product);
      }
    }
  }
  double mean = 0.5 * (mobility[0][0] + mobility[1][1]), half = 0.5 * (mobility[0][0] - mobility[1][1]);
  double span = sqrt(half * half + mobility[1][0] * mobility[1][0]);
  double excess = (mean - span) - IMMOBILE * (mean + span);
  /* NumPy may add in another order: this is more than all rounding of both. */
  double doubt = 16 * (double)(nv + 4) * 2.3e-16 * size;
  if (!(fabs(excess) > doubt)) {
    return -1;
  }
  return excess < 0;
}

/* Leave the noslip pass out of the rest of this step if it has to be; returns 0 with an exception. */
static int suspend_noslip(PhysicsStep* s) {
  mjModel* m = s->m;
  const mjData* d = s->d;
  if (!d->ncon || !m->opt.noslip_iterations || m->opt.cone != mjCONE_ELLIPTIC) {
    return 1;
  }
  const Py_ssize_t* base = index_of(s, GEOM_BASE);
  int is_immobile = 0;
  for (int i = 0; i < d->ncon && is_immobile == 0; i++) {
    const mjContact* contact = d->contact + i;
    if (contact->efc_address >= 0 && contact->dim > 2 &&
        base[geom_of(m, contact, 0)] == base[geom_of(m, contact, 1)]) {
      is_immobile = cannot_move(s, contact->efc_address);
    }
  }
  if (is_immobile < 0) {
    is_immobile = ask(s, s->is_immobile);
  }
  if (is_immobile > 0) {
    s->suspended = m->opt.noslip_iterations;
    m->opt.noslip_iterations = 0;
  }
  return is_immobile >= 0;
}

static void restore_noslip(PhysicsStep* s) {
  if (s->suspended) {
    s->m->opt.noslip_iterations = s->suspended;
    s->suspended = 0;
  }
}


//------------------------------------------ after a physics step: kinematic.py ---------------------

static void hold_kinematic(PhysicsStep* s) {
  mjData* d = s->d;
  double timestep = s->m->opt.timestep;
  for (Py_ssize_t i = 0; i < length(s, STILL_QPOS); i++) {
    d->qpos[index_of(s, STILL_QPOS)[i]] = real(s, STILL_VALUE)[i];
  }
  for (Py_ssize_t i = 0; i < length(s, STILL_DOF); i++) {
    d->qvel[index_of(s, STILL_DOF)[i]] = 0.0;
  }
  for (Py_ssize_t i = 0; i < length(s, REWOUND_QPOS); i++) {
    d->qpos[index_of(s, REWOUND_QPOS)[i]] = real(s, REWOUND_START)[i];
  }
  double* value = real(s, MOVING_VALUE);
  for (Py_ssize_t i = 0; i < length(s, MOVING_QPOS); i++) {
    double before = value[i];
    value[i] = clip(before + real(s, MOVING_RATE)[i] * timestep, real(s, MOVING_LOW)[i], real(s, MOVING_HIGH)[i]);
    d->qpos[index_of(s, MOVING_QPOS)[i]] = value[i];
    d->qvel[index_of(s, MOVING_DOF)[i]] = (value[i] - before) / timestep;
  }
  for (Py_ssize_t i = 0; i < length(s, FOLLOWER_QPOS); i++) {
    double factor = real(s, FOLLOWER_FACTOR)[i];
    double wanted = d->qpos[index_of(s, FOLLOWER_LEAD_QPOS)[i]] * factor + real(s, FOLLOWER_SHIFT)[i];
    d->qpos[index_of(s, FOLLOWER_QPOS)[i]] = clip(wanted, real(s, FOLLOWER_LOW)[i], real(s, FOLLOWER_HIGH)[i]);
    d->qvel[index_of(s, FOLLOWER_DOF)[i]] = d->qvel[index_of(s, FOLLOWER_LEAD_DOF)[i]] * factor;
  }
}


//------------------------------------------ steps -------------------------------------------------

static int one_step(PhysicsStep* s, int flags) {
  control_positions(s);
  control_springs(s);
  control_stiff_springs(s);
  int has_motors = length(s, MOTOR_CTRL) > 0;
  if (!has_motors && !(flags & (LIMIT_SEPARATION | KEEP_DOWN))) {
    mj.step(s->m, s->d); /* whole, since MuJoCo's halves have no RK4 */
    return WELL;
  }
  resist(s);
  mj.step1(s->m, s->d);
  if (flags & LIMIT_SEPARATION) {
    limit_separation(s->m, s->d);
  }
  if (flags & KEEP_DOWN) {
    keep_down(s);
  }
  if (has_motors) {
    if (!grip(s) || !suspend_noslip(s)) {
      return EXCEPTION;
    }
    if (!command_motors(s)) {
      return NO_ROOM;
    }
  }
  mj.step2(s->m, s->d);
  report_motors(s);
  restore_noslip(s);
  return WELL;
}

static int* bad_counts(mjData* d, int which) {
  static const int kinds[] = {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC};
  return &d->warning[kinds[which]].number;
}

static char has_diverged(mjData* d) { return *bad_counts(d, 0) || *bad_counts(d, 1) || *bad_counts(d, 2); }

static char are_finite(const double* values, Py_ssize_t count) {
  for (Py_ssize_t i = 0; i < count; i++) {
    if (!isfinite(values[i])) {
      return 0;
    }
  }
  return 1;
}

/* Update the kinematics; kinematics.py */
static void update(const mjModel* m, mjData* d) {
  mj.kinematics(m, d);
  mj.comPos(m, d);
  mj.camlight(m, d);
  if (m->nflex) {
    mj.flex(m, d);
  }
  if (m->ntendon) {
    mj.tendon(m, d);
  }
}

/* Look at the end of a simulation step. */
static void finish(PhysicsStep* s, int flags) {
  const mjModel* m = s->m;
  mjData* d = s->d;
  s->has_deep_contacts = (char)has_deep_contacts(d);
  s->is_finite = are_finite(d->qpos, (Py_ssize_t)m->nq) && are_finite(d->qvel, (Py_ssize_t)m->nv);
  if (s->is_finite && (flags & UPDATE)) {
    update(m, d);
  }
}

/* Make physics steps `made` to `end` of the `count` of a simulation step, as many as fit into the time. */
static int advance(PhysicsStep* s, Py_ssize_t end, Py_ssize_t count, double limit, int flags) {
  mjData* d = s->d;
  double *force = real(s, MEAN_FORCE), *sensed = real(s, MEAN_SENSED);
  size_t forces = (size_t)length(s, MEAN_FORCE), values = s->has_cells ? (size_t)length(s, MEAN_SENSED) : 0;
  if (s->made == 0) {
    memset(force, 0, forces * sizeof(double));
    memset(sensed, 0, values * sizeof(double));
    for (int i = 0; i < 3; i++) {
      *bad_counts(d, i) = 0;
    }
  }
  double start = seconds();
  while (s->made < end) {
    int result = one_step(s, flags);
    if (result != WELL) {
      return result;
    }
    for (size_t i = 0; i < forces; i++) {
      force[i] += d->actuator_force[i];
    }
    for (size_t i = 0; i < values; i++) {
      sensed[i] += d->sensordata[i];
    }
    hold_kinematic(s);
    s->made++;
    s->has_diverged = has_diverged(d);
    s->seconds = seconds() - start;
    if (s->has_diverged || s->seconds > limit) {
      break;
    }
  }
  if (s->made < count) {
    return WELL;
  }
  if (flags & LAST_FORCE) {
    memcpy(force, d->actuator_force, forces * sizeof(double));
  } else if (count > 1) {
    for (size_t i = 0; i < forces; i++) {
      force[i] /= (double)count;
    }
    for (size_t i = 0; i < values; i++) {
      sensed[i] /= (double)count;
    }
  }
  finish(s, flags);
  return WELL;
}

/* Make steps without the interpreter's lock, in a thread with this state. */
static int run_steps(PhysicsStep* s, Py_ssize_t made, Py_ssize_t end, Py_ssize_t count, double limit, int flags,
                     PyThreadState** thread) {
  s->is_running = 1;
  s->made = made;
  s->thread = *thread;
  restore_noslip(s);

  jmp_buf here, *before = escape;
  volatile int result = FAILED;
  mjfLogHandler handler = mj.setThreadsHandler(on_message);
  escape = &here;
  if (setjmp(here) == 0) {
    result = advance(s, end, count, limit, flags);
  }
  escape = before;
  mj.setThreadsHandler(handler);

  *thread = s->thread;
  restore_noslip(s);
  s->is_running = 0;
  return result;
}

PyDoc_STRVAR(run_doc, "run(made, end, count, seconds, flags)\n\n"
"Make physics steps from number `made` to before `end` of the `count` of a simulation step, without the interpreter's\n"
"lock, until this many seconds have passed. Returns the number of physics steps made in this simulation step.");

static PyObject* run(PyObject* self, PyObject* args) {
  PhysicsStep* s = (PhysicsStep*)self;
  Py_ssize_t made, end, count;
  double limit;
  int flags;
  if (!PyArg_ParseTuple(args, "nnndi", &made, &end, &count, &limit, &flags)) {
    return NULL;
  }
  if (made < 0 || made > end || end > count) {
    PyErr_SetString(PyExc_ValueError, "physics steps are counted from 0 to count");
    return NULL;
  }
  if (s->is_running) {
    PyErr_SetString(PyExc_RuntimeError, "a physics step is in progress");
    return NULL;
  }
  PyThreadState* thread = PyEval_SaveThread();
  int result = run_steps(s, made, end, count, limit, flags, &thread);
  PyEval_RestoreThread(thread);

  if (PyErr_Occurred()) { /* of a function that MuJoCo or this file has called */
    return NULL;
  }
  if (result == FAILED) {
    PyErr_SetString(fatal_error, problem);
    return NULL;
  }
  if (result == NO_ROOM) {
    PyErr_SetString(no_room, "a motor has no constraint");
    return NULL;
  }
  return PyLong_FromSsize_t(s->made);
}


//------------------------------------------ for _crew.c -------------------------------------------

static int run_for_crew(PyObject* step, Py_ssize_t made, Py_ssize_t end, Py_ssize_t count, double limit, int flags,
                        PyThreadState** thread, PhysicsReport* report) {
  PhysicsStep* s = (PhysicsStep*)step;
  report->warning_count = 0;
  s->is_finite = 1;
  s->has_diverged = 0;
  listener = report;
  int result = run_steps(s, made, end, count, limit, flags, thread);
  listener = NULL;
  report->made = s->made;
  report->seconds = s->seconds;
  report->has_diverged = s->has_diverged;
  report->is_finite = s->is_finite;
  report->has_deep_contacts = s->has_deep_contacts;
  if (result == FAILED) {
    copy_text(report->problem, problem);
  }
  return result;
}

static mjModel* model_of(PyObject* step) { return ((PhysicsStep*)step)->m; }
static mjData* data_of(PyObject* step) { return ((PhysicsStep*)step)->d; }

static double* numbers_of(PyObject* step, int column, Py_ssize_t* count) {
  if (column < 0 || column >= COLUMNS || columns[column].indexes != NUMBER) {
    return NULL;
  }
  *count = length((PhysicsStep*)step, column);
  return real((PhysicsStep*)step, column);
}

static PhysicsStepApi api = {
  run_for_crew, model_of, data_of, numbers_of, update, COLUMNS, POSITION_TARGET, SPRING_TARGET, MEAN_FORCE,
};


//------------------------------------------ making ------------------------------------------------

static Py_ssize_t bound(const PhysicsStep* s, int of) {
  switch (of) {
    case OF_QPOS: return (Py_ssize_t)s->m->nq;
    case OF_DOF: return (Py_ssize_t)s->m->nv;
    case OF_CTRL: return (Py_ssize_t)s->m->nu;
    case OF_OUT: return (Py_ssize_t)s->m->nout;
    case OF_TENDON: return (Py_ssize_t)s->m->ntendon;
    case OF_JOINT: return (Py_ssize_t)s->m->njnt;
    case OF_ACTUATOR: return (Py_ssize_t)s->m->nactuator;
    case OF_POSITION: return length(s, POSITION_TARGET);
    case OF_MOTOR: return length(s, MOTOR_CTRL);
    default: return PY_SSIZE_T_MAX;
  }
}

/* Take the array of a column; returns -1 with an exception. */
static int take(PhysicsStep* s, int column, PyObject* table) {
  const char* name = columns[column].name;
  PyObject* array = PyDict_GetItemString(table, name); /* borrowed */
  if (!array) {
    PyErr_Format(PyExc_KeyError, "the table has no column %s", name);
    return -1;
  }
  Py_buffer* view = &s->views[column];
  if (PyObject_GetBuffer(array, view, PyBUF_ND | PyBUF_FORMAT | PyBUF_WRITABLE) < 0) {
    return -1;
  }
  const char* format = view->format ? view->format : "";
  const char* kinds = columns[column].indexes == NUMBER ? "d" : "lqn";
  if (view->ndim != 1 || view->itemsize != 8 || strlen(format) != 1 || !strchr(kinds, format[0])) {
    PyErr_Format(PyExc_TypeError, "column %s is not a plain array of its kind", name);
    return -1;
  }
  return 0;
}

static int check(const PhysicsStep* s, int column) {
  const char* name = columns[column].name;
  if (length(s, column) != length(s, columns[column].like)) {
    PyErr_Format(PyExc_ValueError, "column %s and %s differ in length", name, columns[columns[column].like].name);
    return -1;
  }
  if (columns[column].indexes != NUMBER) {
    Py_ssize_t limit = bound(s, columns[column].indexes);
    for (Py_ssize_t i = 0; i < length(s, column); i++) {
      if (index_of(s, column)[i] < 0 || index_of(s, column)[i] >= limit) {
        PyErr_Format(PyExc_IndexError, "column %s has an index out of the model", name);
        return -1;
      }
    }
  }
  return 0;
}

static int check_all(PhysicsStep* s) {
  for (int column = 0; column < COLUMNS; column++) {
    if (check(s, column) < 0) {
      return -1;
    }
  }
  if (length(s, POSITION_QPOS) + length(s, POSITION_TENDON) != length(s, POSITION_TARGET) ||
      length(s, MOTOR_DOF) + length(s, MOTOR_TENDON) != length(s, MOTOR_CTRL) ||
      length(s, GEOM_BASE) != (Py_ssize_t)s->m->ngeom || length(s, MEAN_FORCE) != (Py_ssize_t)s->m->nout ||
      length(s, MEAN_SENSED) != (Py_ssize_t)s->m->nsensordata) {
    PyErr_SetString(PyExc_ValueError, "the lengths of some columns do not fit the model, or each other");
    return -1;
  }
  for (Py_ssize_t i = 0; i < length(s, MOTOR_ROW); i++) {
    if (index_of(s, MOTOR_ROW)[i] >= s->rows_in_all) {
      PyErr_SetString(PyExc_IndexError, "a motor has a row beyond those of friction");
      return -1;
    }
  }
  return 0;
}

/* Return the address of the struct of a model or data; NULL with an exception. */
static void* address_of(PyObject* object, PyObject* type) {
  int fits = type ? PyObject_IsInstance(object, type) : 0;
  if (fits <= 0) {
    if (fits == 0) {
      PyErr_SetString(PyExc_TypeError, "MuJoCo's model and data are needed, after a call of connect");
    }
    return NULL;
  }
  PyObject* number = PyObject_GetAttrString(object, "_address");
  void* address = number ? PyLong_AsVoidPtr(number) : NULL;
  Py_XDECREF(number);
  if (!address && !PyErr_Occurred()) {
    PyErr_SetString(PyExc_ValueError, "the model or data has no address");
  }
  return address;
}

static void* zeroed(Py_ssize_t count, size_t size) {
  void* memory = calloc((size_t)count + 1, size);
  if (!memory) {
    PyErr_NoMemory();
  }
  return memory;
}

static PyObject* make(PyTypeObject* type, PyObject* args, PyObject* keywords) {
  static char* names[] = {"model", "data", "table", "friction_rows", "averages_sensors", "grip", "is_immobile", NULL};
  PyObject *model, *data, *table, *grip_function, *is_immobile;
  int rows_in_all, has_cells;
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO!ipOO", names, &model, &data, &PyDict_Type, &table,
                                   &rows_in_all, &has_cells, &grip_function, &is_immobile)) {
    return NULL;
  }
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  PhysicsStep* s = (PhysicsStep*)allocate(type, 0); /* zeroed */
  if (!s) {
    return NULL;
  }
  Py_INCREF(model), Py_INCREF(data), Py_INCREF(grip_function), Py_INCREF(is_immobile);
  s->model = model, s->data = data, s->grip = grip_function, s->is_immobile = is_immobile;
  s->rows_in_all = rows_in_all, s->has_cells = has_cells;
  if (!(s->m = address_of(model, model_type)) || !(s->d = address_of(data, data_type))) {
    goto fail;
  }
  for (int column = 0; column < COLUMNS; column++) {
    if (take(s, column, table) < 0) {
      goto fail;
    }
  }
  if (check_all(s) < 0) {
    goto fail;
  }
  Py_ssize_t motors = length(s, MOTOR_CTRL);
  if (!(s->wanted = zeroed(motors, sizeof(double))) || !(s->rows = zeroed(motors, sizeof(int))) ||
      !(s->is_stuck = zeroed(motors, 1))) {
    goto fail;
  }
  for (Py_ssize_t i = 0; i < length(s, POSITION_TARGET); i++) {
    s->has_terms |= real(s, POSITION_INTEGRAL)[i] != 0 || real(s, POSITION_DERIVATIVE)[i] != 0;
  }
  s->is_elliptic = s->m->opt.cone == mjCONE_ELLIPTIC;
  return (PyObject*)s;

fail:
  Py_DECREF(s);
  return NULL;
}

static void forget(PyObject* self) {
  PhysicsStep* s = (PhysicsStep*)self;
  PyTypeObject* type = Py_TYPE(self);
  for (int column = 0; column < COLUMNS; column++) {
    PyBuffer_Release(&s->views[column]); /* does nothing for one that was never taken */
  }
  Py_XDECREF(s->model), Py_XDECREF(s->data), Py_XDECREF(s->grip), Py_XDECREF(s->is_immobile);
  free(s->wanted), free(s->rows), free(s->is_stuck), free(s->scratch);
  freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
  release(self);
  Py_DECREF(type);
}

static PyMethodDef methods[] = {{"run", run, METH_VARARGS, run_doc}, {NULL, NULL, 0, NULL}};

static PyMemberDef members[] = {
  {"is_finite", T_BOOL, offsetof(PhysicsStep, is_finite), READONLY, NULL},
  {"has_diverged", T_BOOL, offsetof(PhysicsStep, has_diverged), READONLY, NULL},
  {"seconds", T_DOUBLE, offsetof(PhysicsStep, seconds), READONLY, NULL},
  {"has_deep_contacts", T_BOOL, offsetof(PhysicsStep, has_deep_contacts), READONLY, NULL},
  {NULL, 0, 0, 0, NULL},
};

static PyType_Slot slots[] = {
  {Py_tp_new, make}, {Py_tp_dealloc, forget}, {Py_tp_methods, methods}, {Py_tp_members, members},
  {0, NULL},
};

static PyType_Spec spec = {
  "simx_server.joints.native._physics_step.PhysicsStep", sizeof(PhysicsStep), 0, Py_TPFLAGS_DEFAULT, slots,
};

PyDoc_STRVAR(connect_doc, "connect(addresses, model_type, data_type, fatal_error)\n\n"
"Use the functions of the loaded MuJoCo: their addresses by name, its classes, and the exception of its errors.");

static PyObject* connect(PyObject* module, PyObject* args) {
  (void)module;
  PyObject *addresses, *model, *data, *fatal;
  if (!PyArg_ParseTuple(args, "O!OOO", &PyDict_Type, &addresses, &model, &data, &fatal)) {
    return NULL;
  }
  const Wanted wanted[] = {
    {"mj_step", (void**)&mj.step}, {"mj_step1", (void**)&mj.step1}, {"mj_step2", (void**)&mj.step2},
    {"mj_mulJacVec", (void**)&mj.mulJacVec}, {"mj_solveM", (void**)&mj.solveM},
    {"mj_kinematics", (void**)&mj.kinematics}, {"mj_comPos", (void**)&mj.comPos},
    {"mj_camlight", (void**)&mj.camlight}, {"mj_flex", (void**)&mj.flex}, {"mj_tendon", (void**)&mj.tendon},
    {"mj_isSparse", (void**)&mj.isSparse}, {"_mjPRIVATE_setTlsLogHandler", (void**)&mj.setThreadsHandler},
    {"_mjPRIVATE_getGlobalLogHandler", (void**)&mj.getHandler},
  };
  if (take_addresses(addresses, wanted, sizeof(wanted) / sizeof(*wanted)) < 0) {
    return NULL;
  }
  Py_INCREF(model), Py_INCREF(data), Py_INCREF(fatal);
  Py_XDECREF(model_type), Py_XDECREF(data_type), Py_XDECREF(fatal_error);
  model_type = model, data_type = data, fatal_error = fatal;
  Py_INCREF(Py_None);
  return Py_None;
}

static PyMethodDef functions[] = {{"connect", connect, METH_VARARGS, connect_doc}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef definition = {
  PyModuleDef_HEAD_INIT, "_physics_step", "Physics steps with motors and controllers, compiled.", -1, functions,
  NULL, NULL, NULL, NULL,
};

#ifndef SOURCE_HASH
#define SOURCE_HASH ""
#endif

PyMODINIT_FUNC PyInit__physics_step(void) {
  PyObject* module = PyModule_Create(&definition);
  PyObject* type = module ? PyType_FromSpec(&spec) : NULL;
  no_room = type ? PyErr_NewException("simx_server.joints.native._physics_step.NoRoom", NULL, NULL) : NULL;
  PyObject* offered = no_room ? PyCapsule_New(&api, PHYSICS_STEP_API, NULL) : NULL;
  if (!offered || PyModule_AddObjectRef(module, "PhysicsStep", type) < 0 ||
      PyModule_AddObjectRef(module, "API", offered) < 0 ||
      PyModule_AddObjectRef(module, "NoRoom", no_room) < 0 ||
      PyModule_AddIntConstant(module, "HEADER", mjVERSION_HEADER) < 0 ||
      PyModule_AddIntConstant(module, "LIMIT_SEPARATION", LIMIT_SEPARATION) < 0 ||
      PyModule_AddIntConstant(module, "KEEP_DOWN", KEEP_DOWN) < 0 ||
      PyModule_AddIntConstant(module, "LAST_FORCE", LAST_FORCE) < 0 ||
      PyModule_AddIntConstant(module, "UPDATE", UPDATE) < 0 ||
      PyModule_AddStringConstant(module, "SOURCE_HASH", SOURCE_HASH) < 0) {
    Py_XDECREF(module);
    module = NULL;
  }
  Py_XDECREF(offered);
  Py_XDECREF(type);
  return module;
}
