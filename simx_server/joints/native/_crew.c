/* Several worlds of one process step together: a pool of threads, and what each world does in its steps.

   A course has the physics steps of one world, and operations: writes of targets before a simulation step, reads of
   positions after it. They do what the handlers of the calls do, operation by operation, in single precision where a
   message has it, so a world gives the same numbers bit for bit as one that is called. A formula that changes here
   changes there; tests/server/joints/test_crew.py holds both equal.

   A crew has the courses of all worlds, and the threads. `step` and `restart` do everything of all worlds in one call;
   `submit` and `next` let Python do something before and after the physics of each world. The caller's thread works too,
   so nothing waits for a thread to wake up, and one thread alone is as fast as a loop.

   The threads use Python's locks: a lock that one thread holds and another one releases is the only signal between
   them. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L
#endif
#include <Python.h>
#include <structmember.h>

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "physics_step.h"

#define PI 3.141592653589793

/* as in ../servo.py and ../../scene/poses/frames.py */
#define LEAST_FORCE 1e-12
#define GIMBAL_LOCK 0.999995

#define PATIENCE 1.0      /* seconds of a simulation step after which Python looks at it */
#define WORTHWHILE 15e-6  /* seconds of work below which no other thread is called */
#define PERIOD 512        /* calls between two trials of the slower way, with or without other threads */
#define TRIAL 8           /* calls of a trial */
#define WARM_UP 3         /* calls of it that do not count: a thread that sleeps takes long to wake */
#define SPIN 150e-6       /* seconds of a busy wait before a thread sleeps: to wake it takes about as long */
#define LOOKS 64          /* at a lock between two looks at the clock */

static PhysicsStepApi* physics;
static PyObject* step_type;

static struct {
  void (*resetData)(const mjModel*, mjData*);
  int (*stateSize)(const mjModel*, int);
  void (*getState)(const mjModel*, const mjData*, mjtNum*, int);
  void (*setState)(const mjModel*, mjData*, const mjtNum*, int);
} mj;

/* A number as a message carries it. */
static double single(double value) { return (double)(float)value; }

/* joints.py: the angle in -pi..pi */
static double wrapped(double angle) {
  return (-PI <= angle && angle <= PI) || !isfinite(angle) ? angle : remainder(angle, 2 * PI);
}


//------------------------------------------ poses: scene/poses/poses.py ----------------------------

typedef struct { double p[3], q[4]; } Pose;

static const Pose identity = {{0, 0, 0}, {1, 0, 0, 0}};

static void multiply(double* result, const double* a, const double* b) {
  double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
  result[0] = w, result[1] = x, result[2] = y, result[3] = z;
}

static void conjugate(double* result, const double* q) {
  result[0] = q[0], result[1] = -q[1], result[2] = -q[2], result[3] = -q[3];
}

static void rotate(double* result, const double* q, const double* v) {
  double w = q[0], x = q[1], y = q[2], z = q[3];
  double tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]), tz = 2 * (x * v[1] - y * v[0]);
  double rx = v[0] + w * tx + y * tz - z * ty;
  double ry = v[1] + w * ty + z * tx - x * tz;
  double rz = v[2] + w * tz + x * ty - y * tx;
  result[0] = rx, result[1] = ry, result[2] = rz;
}

static Pose compose(const Pose* outer, const Pose* inner) {
  Pose result;
  rotate(result.p, outer->q, inner->p);
  for (int i = 0; i < 3; i++) {
    result.p[i] = outer->p[i] + result.p[i];
  }
  multiply(result.q, outer->q, inner->q);
  return result;
}

static Pose inverse(const Pose* pose) {
  Pose result;
  conjugate(result.q, pose->q);
  rotate(result.p, result.q, pose->p);
  for (int i = 0; i < 3; i++) {
    result.p[i] = result.p[i] * -1.0;
  }
  return result;
}

/* frames.py: euler_from_quat */
static void euler_angles(double* angles, const double* q) {
  double w = q[0], x = q[1], y = q[2], z = q[3];
  double m00 = 1 - 2 * (y * y + z * z), m01 = 2 * (x * y - w * z), m02 = 2 * (x * z + w * y);
  double sine = greater(-1.0, lesser(1.0, m02));
  angles[1] = asin(sine);
  if (fabs(sine) >= GIMBAL_LOCK) {
    double m10 = 2 * (x * y + w * z), m11 = 1 - 2 * (x * x + z * z);
    angles[0] = 0.0, angles[2] = atan2(m10, m11);
    return;
  }
  double m12 = 2 * (y * z - w * x), m22 = 1 - 2 * (x * x + y * y);
  angles[0] = atan2(-m12, m22), angles[2] = atan2(-m01, m00);
}

/* poses.py: rotation_vector */
static void rotation_vector(double* vector, const double* q) {
  double sign = q[0] < 0 ? -1.0 : 1.0, w = sign * q[0], x = sign * q[1], y = sign * q[2], z = sign * q[3];
  double s = sqrt(x * x + y * y + z * z);
  double factor = s < 1e-15 ? 2 : 2 * atan2(s, w) / s;
  vector[0] = x * factor, vector[1] = y * factor, vector[2] = z * factor;
}


//------------------------------------------ operations --------------------------------------------

/* Each has an entry of Python's lists in ../../gateways/embedded/crew/operations.py. */
enum { TARGET, SPRING, CYCLIC_SPRING, COMMAND, FORCE, PLACE, WRITES };
enum { POSITION, LENGTH, RATE, MOTOR_FORCE, BODY_POSITION, POSE_POSITION, POSE_QUATERNION, POSE_ANGLES, VELOCITY,
       ANGULAR_VELOCITY, READS };
static const Py_ssize_t result_counts[READS] = {1, 1, 1, 1, 3, 3, 4, 3, 6, 6};

typedef struct {
  int kind;
  Py_ssize_t i, j, k, p, q;
  double a, b, c;
  Py_ssize_t at; /* number of its value, or of its first result */
} Operation;

typedef struct {
  Operation* of;
  Py_ssize_t count;
  Py_ssize_t width; /* values or results of all */
} Operations;

typedef struct {
  PyObject_HEAD
  PyObject* step; /* of _physics_step.c; owns m and d */
  mjModel* m;
  mjData* d;
  Py_ssize_t substeps;
  int flags;          /* of every simulation step */
  int may_skip_means; /* without corrections of contacts nothing has to be averaged */
  double time_step;
  Operations writes, starts, reads;
  double *written, *started; /* the last values */
  Py_ssize_t frame_count;
  Pose* frames; /* of objects, in those of their bodies */

  /* measured.py: positions of joints and tendons, before and after the last simulation step */
  Py_ssize_t positions;
  double *before, *after;
  char has_before, has_after;

  /* velocities.py: poses at the ends of the last two simulation steps */
  Py_buffer block;
  double *poses_before, *poses_after;

  char is_rearranged, has_overlaps; /* of simulation.py */
  char was_written;                 /* values of a step, since the lending or the last restart */
  char is_open;                     /* a simulation step was left before its end */
  int last_flags;                   /* of the physics of the last simulation step */
  Py_ssize_t steps;                 /* simulation steps since the lending or the last restart */
  Py_ssize_t all_steps;             /* since the lending */
  Py_ssize_t restarts;

  /* the start of an episode, before the first physics step */
  double *state, *numbers, *losses, *tendon_losses, *biases, *first_poses;
  char is_captured;

  /* of the last job */
  int outcome;
  Py_ssize_t done; /* simulation steps */
  PyObject* error; /* of Python */
  PhysicsReport report;
} Course;

enum { REFUSED = FAILED + 1, UNFINISHED }; /* outcomes beside those of a run; REFUSED: nothing was done */

static void write_values(Course* c, const Operations* operations, const double* values) {
  mjModel* m = c->m;
  mjData* d = c->d;
  for (Py_ssize_t n = 0; n < operations->count; n++) {
    const Operation* o = operations->of + n;
    double value = single(values[o->at]);
    Py_ssize_t count;
    switch (o->kind) {
      case TARGET: /* set_target_position, of a position controller */
        physics->numbers(c->step, physics->position_target, &count)[o->i] = o->j ? wrapped(value) : value;
        break;
      case CYCLIC_SPRING: /* and of a spring that pulls the short way round */
        value = wrapped(value);
        physics->numbers(c->step, physics->spring_target, &count)[o->i] = value;
        d->ctrl[o->j] = (value - o->b) * o->a;
        break;
      case SPRING: /* set_target_position, of a spring and damper */
        d->ctrl[o->i] = (value - o->b) * o->a;
        break;
      case COMMAND: /* set_target_velocity, in velocity control */
        d->ctrl[o->i] = lesser(greater(value, -o->b), o->b) * o->a;
        break;
      case FORCE: { /* set_max_force, of a motor */
        double most = greater(fabs(value), o->a);
        if (o->j) {
          m->tendon_frictionloss[o->i] = greater(most, LEAST_FORCE);
          break;
        }
        if (m->jnt_actfrclimited[o->k]) {
          const mjtNum* range = m->jnt_actfrcrange + 2 * o->k;
          most = lesser(most, fmax(fabs(range[0]), fabs(range[1])));
        }
        m->dof_frictionloss[o->i] = greater(most, LEAST_FORCE);
        break;
      }
      case PLACE: /* set_position, of a joint that nothing else holds */
        d->qpos[o->i] = o->k ? wrapped(value) : lesser(greater(value, o->a), o->b);
        d->qvel[o->j] = 0.0;
        c->is_rearranged = 1;
        break;
    }
  }
}

static Pose body_pose(const Course* c, Py_ssize_t body) {
  Pose pose;
  if (body == 0) {
    return identity;
  }
  memcpy(pose.p, c->d->xpos + 3 * body, sizeof(pose.p));
  memcpy(pose.q, c->d->xquat + 4 * body, sizeof(pose.q));
  return pose;
}

/* The pose of a body, or of something in its frame. */
static Pose pose_of(const Course* c, Py_ssize_t body, Py_ssize_t frame) {
  Pose pose = body_pose(c, body);
  return frame < 0 ? pose : compose(&pose, c->frames + frame);
}

static double rate_of(const Course* c, const Operation* o) {
  if (!c->has_before || !c->has_after) {
    return 0.0;
  }
  double change = c->after[o->i] - c->before[o->i];
  if (o->j && isfinite(change)) {
    change = remainder(change, 2 * PI);
  }
  return change / c->time_step;
}

static double motor_force(const Course* c, const Operation* o) {
  if (c->steps == 0) {
    return 0.0;
  }
  Py_ssize_t count;
  double force = physics->numbers(c->step, physics->mean_force, &count)[o->i] * o->a;
  if (o->j >= 0 && c->m->jnt_actfrclimited[o->j]) {
    const mjtNum* range = c->m->jnt_actfrcrange + 2 * o->j;
    force = lesser(greater(force, range[0]), range[1]);
  }
  return 0.0 - force;
}

static void velocities(const Course* c, const Operation* o, double* out) {
  const double *before = c->poses_before, *after = c->poses_after;
  double rate = 1.0 / c->time_step, back[4], turn[4];
  for (int i = 0; i < 3; i++) {
    out[i] = (after[o->i + i] - before[o->i + i]) * rate;
  }
  conjugate(back, before + o->j);
  multiply(turn, after + o->j, back);
  if (o->kind == VELOCITY) {
    euler_angles(out + 3, turn);
  } else {
    rotation_vector(out + 3, turn);
  }
  for (int i = 3; i < 6; i++) {
    out[i] = out[i] * rate;
  }
}

static void read_results(const Course* c, double* results) {
  const mjData* d = c->d;
  for (Py_ssize_t n = 0; n < c->reads.count; n++) {
    const Operation* o = c->reads.of + n;
    double* out = results + o->at;
    switch (o->kind) {
      case POSITION:
        out[0] = o->j ? wrapped(d->qpos[o->i] + o->a) : d->qpos[o->i] + o->a;
        break;
      case LENGTH:
        out[0] = d->ten_length[o->i] + o->a;
        break;
      case RATE:
        out[0] = rate_of(c, o);
        break;
      case MOTOR_FORCE:
        out[0] = motor_force(c, o);
        break;
      case BODY_POSITION:
        memcpy(out, d->xpos + 3 * o->i, 3 * sizeof(double));
        break;
      case VELOCITY:
      case ANGULAR_VELOCITY:
        velocities(c, o, out);
        break;
      default: { /* of an object in the frame of another one */
        Pose pose = pose_of(c, o->i, o->p);
        if (o->j >= 0) {
          Pose reference = pose_of(c, o->j, o->q), back = inverse(&reference);
          pose = compose(&back, &pose);
        }
        if (o->kind == POSE_POSITION) {
          memcpy(out, pose.p, sizeof(pose.p));
        } else if (o->kind == POSE_ANGLES) {
          euler_angles(out, pose.q);
        } else {
          double sign = pose.q[0] < 0 ? -1.0 : 1.0;
          out[0] = sign * pose.q[1], out[1] = sign * pose.q[2], out[2] = sign * pose.q[3], out[3] = sign * pose.q[0];
        }
      }
    }
    for (Py_ssize_t i = 0; i < result_counts[o->kind]; i++) {
      out[i] = single(out[i]);
    }
  }
}


//------------------------------------------ simulation steps --------------------------------------

static void copy_positions(const Course* c, double* to) {
  memcpy(to, c->d->qpos, (size_t)c->m->nq * sizeof(double));
  memcpy(to + c->m->nq, c->d->ten_length, (size_t)c->m->ntendon * sizeof(double));
}

static void swap(double** a, double** b) {
  double* kept = *a;
  *a = *b, *b = kept;
}

/* One simulation step. */
static int simulate(Course* c, PyThreadState** thread) {
  if (c->has_after) {
    swap(&c->before, &c->after);
  } else {
    copy_positions(c, c->before);
  }
  c->has_before = 1, c->has_after = 0;
  int flags = c->flags;
  if (c->is_rearranged || c->has_overlaps) {
    flags |= LIMIT_SEPARATION;
  }
  if (c->may_skip_means && !(flags & (LIMIT_SEPARATION | KEEP_DOWN))) {
    flags |= LAST_FORCE;
  }
  c->is_rearranged = 0;
  c->last_flags = flags | UPDATE;
  c->is_open = 1;
  int result = physics->run(c->step, 0, c->substeps, c->substeps, PATIENCE, flags | UPDATE, thread, &c->report);
  if (result != WELL) {
    return result;
  }
  if (c->report.has_diverged || !c->report.is_finite || c->report.made < c->substeps) {
    return UNFINISHED;
  }
  c->is_open = 0;
  c->has_overlaps = c->report.has_deep_contacts;
  swap(&c->poses_before, &c->poses_after);
  memcpy(c->poses_after, c->block.buf, (size_t)c->block.len);
  copy_positions(c, c->after);
  c->has_after = 1;
  c->steps++;
  c->all_steps++;
  return WELL;
}

static char are_finite(const Operations* operations, const double* values) {
  for (Py_ssize_t i = 0; i < operations->width; i++) {
    if (!isfinite(single(values[i]))) {
      return 0;
    }
  }
  return 1;
}

static int make_steps(Course* c, const double* values, double* results, Py_ssize_t times, PyThreadState** thread) {
  if (!are_finite(&c->writes, values)) {
    return REFUSED;
  }
  write_values(c, &c->writes, values);
  memcpy(c->written, values, (size_t)c->writes.width * sizeof(double));
  c->was_written = 1;
  for (c->done = 0; c->done < times; c->done++) {
    int result = simulate(c, thread);
    if (result != WELL) {
      return result;
    }
  }
  read_results(c, results);
  return WELL;
}

/* Start another episode: stop and start restore the state, then the values of the start are written. */
static int start_again(Course* c, const double* values, double* results) {
  mjModel* m = c->m;
  mjData* d = c->d;
  if (!c->is_captured || !are_finite(&c->starts, values)) {
    return REFUSED;
  }
  mj.resetData(m, d);
  mj.setState(m, d, c->state, mjSTATE_INTEGRATION);
  const double* saved = c->numbers;
  for (int column = 0; column < physics->columns; column++) {
    Py_ssize_t count;
    double* numbers = physics->numbers(c->step, column, &count);
    if (numbers) {
      memcpy(numbers, saved, (size_t)count * sizeof(double));
      saved += count;
    }
  }
  memcpy(m->dof_frictionloss, c->losses, (size_t)m->nv * sizeof(double));
  memcpy(m->tendon_frictionloss, c->tendon_losses, (size_t)m->ntendon * sizeof(double));
  memcpy(m->actuator_biasprm, c->biases, (size_t)m->nactuator * mjNBIAS * sizeof(double));
  memcpy(c->poses_before, c->first_poses, (size_t)c->block.len);
  memcpy(c->poses_after, c->first_poses, (size_t)c->block.len);
  c->has_before = c->has_after = 0;
  c->steps = 0;
  c->restarts++;
  c->was_written = 0;
  c->is_rearranged = 1;
  write_values(c, &c->starts, values);
  memcpy(c->started, values, (size_t)c->starts.width * sizeof(double));

  int flags = m->opt.enableflags; /* sleepers.py: what was moved is awake */
  m->opt.enableflags = flags & ~mjENBL_SLEEP;
  physics->update(m, d);
  m->opt.enableflags = flags;
  read_results(c, results);
  return WELL;
}


//------------------------------------------ courses for Python ------------------------------------

static void forget_operations(Operations* operations) {
  free(operations->of);
  operations->of = NULL;
  operations->count = operations->width = 0;
}

static int is_within(Py_ssize_t index, Py_ssize_t count) { return index >= 0 && index < count; }

static int is_valid_write(const Course* c, const Operation* o) {
  const mjModel* m = c->m;
  Py_ssize_t targets = 0, springs = 0;
  physics->numbers(c->step, physics->position_target, &targets);
  physics->numbers(c->step, physics->spring_target, &springs);
  switch (o->kind) {
    case TARGET: return is_within(o->i, targets);
    case CYCLIC_SPRING: return is_within(o->i, springs) && is_within(o->j, m->nu);
    case SPRING:
    case COMMAND: return is_within(o->i, m->nu);
    case FORCE: return o->j ? is_within(o->i, m->ntendon) : is_within(o->i, m->nv) && is_within(o->k, m->njnt);
    case PLACE: return is_within(o->i, m->nq) && is_within(o->j, m->nv);
    default: return 0;
  }
}

static int is_valid_read(const Course* c, const Operation* o) {
  const mjModel* m = c->m;
  Py_ssize_t forces = 0, block = c->block.len / (Py_ssize_t)sizeof(double);
  physics->numbers(c->step, physics->mean_force, &forces);
  switch (o->kind) {
    case POSITION: return is_within(o->i, m->nq);
    case LENGTH: return is_within(o->i, m->ntendon);
    case RATE: return is_within(o->i, c->positions);
    case MOTOR_FORCE: return is_within(o->i, forces) && o->j < m->njnt;
    case BODY_POSITION: return is_within(o->i, m->nbody);
    case VELOCITY:
    case ANGULAR_VELOCITY: return is_within(o->i, block - 2) && is_within(o->j, block - 3);
    case POSE_POSITION:
    case POSE_QUATERNION:
    case POSE_ANGLES:
      return is_within(o->i, m->nbody) && o->j < m->nbody && o->p < c->frame_count && o->q < c->frame_count;
    default: return 0;
  }
}

/* Take a list of tuples; returns -1 with an exception. */
static int take_operations(Course* c, PyObject* list, Operations* operations, int are_reads) {
  Py_ssize_t count = PyList_Size(list);
  if (count < 0 || !(operations->of = calloc((size_t)count + 1, sizeof(Operation)))) {
    return PyErr_Occurred() ? -1 : (PyErr_NoMemory(), -1);
  }
  for (Py_ssize_t n = 0; n < count; n++) {
    Operation* o = operations->of + n;
    PyObject* item = PyList_GetItem(list, n); /* borrowed */
    if (!PyArg_ParseTuple(item, "innnnnddd", &o->kind, &o->i, &o->j, &o->k, &o->p, &o->q, &o->a, &o->b, &o->c)) {
      return -1;
    }
    if (!(are_reads ? is_valid_read(c, o) : is_valid_write(c, o))) {
      PyErr_Format(PyExc_IndexError, "operation %zd has an index out of the model", n);
      return -1;
    }
    o->at = operations->width;
    operations->width += are_reads ? result_counts[o->kind] : 1;
  }
  operations->count = count;
  return 0;
}

static double* room_for(Py_ssize_t count) {
  double* numbers = calloc((size_t)count + 1, sizeof(double));
  if (!numbers) {
    PyErr_NoMemory();
  }
  return numbers;
}

static PyObject* make_course(PyTypeObject* type, PyObject* args, PyObject* keywords) {
  static char* names[] = {"step", "substeps", "flags", "may_skip_means", "time_step", "writes", "starts", "reads",
                          "frames", "block", NULL};
  PyObject *step, *writes, *starts, *reads, *frames, *block;
  Py_ssize_t substeps;
  int flags, may_skip_means;
  double time_step;
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "OnipdO!O!O!OO", names, &step, &substeps, &flags, &may_skip_means,
                                   &time_step, &PyList_Type, &writes, &PyList_Type, &starts, &PyList_Type, &reads,
                                   &frames, &block)) {
    return NULL;
  }
  int fits = step_type ? PyObject_IsInstance(step, step_type) : 0;
  if (fits <= 0) {
    if (fits == 0) {
      PyErr_SetString(PyExc_TypeError, "physics steps are needed, after a call of connect");
    }
    return NULL;
  }
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  Course* c = (Course*)allocate(type, 0); /* zeroed */
  if (!c) {
    return NULL;
  }
  Py_INCREF(step);
  c->step = step, c->m = physics->model(step), c->d = physics->data(step);
  c->substeps = substeps, c->flags = flags, c->may_skip_means = may_skip_means, c->time_step = time_step;
  c->positions = (Py_ssize_t)c->m->nq + (Py_ssize_t)c->m->ntendon;
  Py_buffer given;
  if (PyObject_GetBuffer(frames, &given, PyBUF_CONTIG_RO) < 0) {
    goto fail;
  }
  c->frame_count = given.len / (Py_ssize_t)sizeof(Pose);
  c->frames = (Pose*)room_for(c->frame_count * 7);
  if (c->frames) {
    memcpy(c->frames, given.buf, (size_t)c->frame_count * sizeof(Pose));
  }
  PyBuffer_Release(&given);
  if (!c->frames || PyObject_GetBuffer(block, &c->block, PyBUF_CONTIG_RO) < 0) {
    goto fail;
  }
  Py_ssize_t numbers = c->block.len / (Py_ssize_t)sizeof(double);
  if (!(c->before = room_for(c->positions)) || !(c->after = room_for(c->positions)) ||
      !(c->poses_before = room_for(numbers)) || !(c->poses_after = room_for(numbers)) ||
      take_operations(c, writes, &c->writes, 0) < 0 || take_operations(c, starts, &c->starts, 0) < 0 ||
      take_operations(c, reads, &c->reads, 1) < 0 || !(c->written = room_for(c->writes.width)) ||
      !(c->started = room_for(c->starts.width))) {
    goto fail;
  }
  return (PyObject*)c;

fail:
  Py_DECREF(c);
  return NULL;
}

static void forget_course(PyObject* self) {
  Course* c = (Course*)self;
  PyTypeObject* type = Py_TYPE(self);
  PyBuffer_Release(&c->block); /* does nothing for one that was never taken */
  forget_operations(&c->writes), forget_operations(&c->starts), forget_operations(&c->reads);
  free(c->written), free(c->started);
  free(c->frames), free(c->before), free(c->after), free(c->poses_before), free(c->poses_after);
  free(c->state), free(c->numbers), free(c->losses), free(c->tendon_losses), free(c->biases), free(c->first_poses);
  Py_XDECREF(c->step), Py_XDECREF(c->error);
  freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
  release(self);
  Py_DECREF(type);
}

/* Copy the numbers of an array; returns -1 with an exception. */
static int copy_numbers(double* to, PyObject* array, Py_ssize_t size) {
  Py_buffer given;
  if (PyObject_GetBuffer(array, &given, PyBUF_CONTIG_RO) < 0) {
    return -1;
  }
  int fits = given.len == size;
  if (fits) {
    memcpy(to, given.buf, (size_t)size);
  } else {
    PyErr_SetString(PyExc_ValueError, "an array has another size than the model's");
  }
  PyBuffer_Release(&given);
  return fits ? 0 : -1;
}

PyDoc_STRVAR(begin_doc, "begin(positions, poses, is_rearranged, has_overlaps)\n\n"
"Go on from the end of a simulation step that Python has made: positions of joints and tendons (None: it was not made in\n"
"this run), poses, whether something was moved since, whether shapes overlap deeply.");

static PyObject* begin(PyObject* self, PyObject* args) {
  Course* c = (Course*)self;
  PyObject *positions, *poses;
  int is_rearranged, has_overlaps;
  if (!PyArg_ParseTuple(args, "OOpp", &positions, &poses, &is_rearranged, &has_overlaps)) {
    return NULL;
  }
  c->has_before = 0;
  c->has_after = positions != Py_None;
  if ((c->has_after && copy_numbers(c->after, positions, c->positions * (Py_ssize_t)sizeof(double)) < 0) ||
      copy_numbers(c->poses_after, poses, c->block.len) < 0) {
    return NULL;
  }
  memcpy(c->poses_before, c->poses_after, (size_t)c->block.len);
  c->is_rearranged = (char)is_rearranged, c->has_overlaps = (char)has_overlaps;
  c->was_written = c->is_open = 0;
  c->steps = c->all_steps = c->restarts = 0;
  Py_INCREF(Py_None);
  return Py_None;
}

PyDoc_STRVAR(capture_doc, "capture()\n\n"
"Keep the state before the first physics step of an episode, to which a restart of the crew goes back.");

static PyObject* capture(PyObject* self, PyObject* ignored) {
  (void)ignored;
  Course* c = (Course*)self;
  mjModel* m = c->m;
  Py_ssize_t numbers = 0;
  for (int column = 0; column < physics->columns; column++) {
    Py_ssize_t count;
    numbers += physics->numbers(c->step, column, &count) ? count : 0;
  }
  if (!c->is_captured &&
      (!(c->state = room_for(mj.stateSize(m, mjSTATE_INTEGRATION))) || !(c->numbers = room_for(numbers)) ||
       !(c->losses = room_for((Py_ssize_t)m->nv)) || !(c->tendon_losses = room_for((Py_ssize_t)m->ntendon)) ||
       !(c->biases = room_for((Py_ssize_t)m->nactuator * mjNBIAS)) ||
       !(c->first_poses = room_for(c->block.len / (Py_ssize_t)sizeof(double))))) {
    return NULL;
  }
  mj.getState(m, c->d, c->state, mjSTATE_INTEGRATION);
  double* saved = c->numbers;
  for (int column = 0; column < physics->columns; column++) {
    Py_ssize_t count;
    const double* present = physics->numbers(c->step, column, &count);
    if (present) {
      memcpy(saved, present, (size_t)count * sizeof(double));
      saved += count;
    }
  }
  memcpy(c->losses, m->dof_frictionloss, (size_t)m->nv * sizeof(double));
  memcpy(c->tendon_losses, m->tendon_frictionloss, (size_t)m->ntendon * sizeof(double));
  memcpy(c->biases, m->actuator_biasprm, (size_t)m->nactuator * mjNBIAS * sizeof(double));
  memcpy(c->first_poses, c->poses_after, (size_t)c->block.len);
  c->is_captured = 1;
  Py_INCREF(Py_None);
  return Py_None;
}

static PyObject* as_bytes(const double* numbers, Py_ssize_t size) {
  return PyBytes_FromStringAndSize((const char*)numbers, size);
}

PyDoc_STRVAR(memory_doc, "memory()\n\n"
"Return the positions before and after the last simulation step (None: there are none), the poses, and the last values of\n"
"starts and of writes, as bytes.");

static PyObject* memory(PyObject* self, PyObject* ignored) {
  (void)ignored;
  Course* c = (Course*)self;
  Py_ssize_t size = c->positions * (Py_ssize_t)sizeof(double);
  Py_INCREF(Py_None), Py_INCREF(Py_None);
  PyObject *before = Py_None, *after = Py_None;
  if (c->has_before && !(before = as_bytes(c->before, size))) {
    return NULL;
  }
  if (c->has_after && !(after = as_bytes(c->after, size))) {
    return NULL;
  }
  return Py_BuildValue("NNNNNN", before, after, as_bytes(c->poses_before, c->block.len),
                       as_bytes(c->poses_after, c->block.len),
                       as_bytes(c->started, c->starts.width * (Py_ssize_t)sizeof(double)),
                       as_bytes(c->written, c->writes.width * (Py_ssize_t)sizeof(double)));
}

/* Take a row of numbers; returns NULL with an exception. */
static double* row_of(PyObject* array, Py_buffer* view, Py_ssize_t width, int is_written) {
  if (PyObject_GetBuffer(array, view, is_written ? PyBUF_CONTIG : PyBUF_CONTIG_RO) < 0) {
    return NULL;
  }
  if (view->itemsize != sizeof(double) || view->len < width * (Py_ssize_t)sizeof(double)) {
    PyErr_SetString(PyExc_ValueError, "an array has too few numbers");
    PyBuffer_Release(view);
    return NULL;
  }
  return view->buf;
}

PyDoc_STRVAR(read_doc, "read(results)\n\nPut what the reads find into a row of numbers.");

static PyObject* read_now(PyObject* self, PyObject* array) {
  Course* c = (Course*)self;
  Py_buffer view;
  double* results = row_of(array, &view, c->reads.width, 1);
  if (!results) {
    return NULL;
  }
  read_results(c, results);
  PyBuffer_Release(&view);
  Py_INCREF(Py_None);
  return Py_None;
}

PyDoc_STRVAR(write_doc, "write(values)\n\n"
"Write the values of a row; returns False, and writes nothing, if one of them is not finite.");

static PyObject* write_now(PyObject* self, PyObject* array) {
  Course* c = (Course*)self;
  Py_buffer view;
  double* values = row_of(array, &view, c->writes.width, 0);
  if (!values) {
    return NULL;
  }
  int is_valid = are_finite(&c->writes, values);
  if (is_valid) {
    write_values(c, &c->writes, values);
  }
  PyBuffer_Release(&view);
  return PyBool_FromLong(is_valid);
}

static PyObject* warnings_of(PyObject* self, void* ignored) {
  (void)ignored;
  Course* c = (Course*)self;
  PyObject* list = PyList_New(0);
  for (int i = 0; list && i < c->report.warning_count; i++) {
    PyObject* text = PyUnicode_DecodeUTF8(c->report.warnings[i], (Py_ssize_t)strlen(c->report.warnings[i]), "replace");
    if (!text || PyList_Append(list, text) < 0) {
      Py_XDECREF(list);
      list = NULL;
    }
    Py_XDECREF(text);
  }
  return list;
}

static PyObject* problem_of(PyObject* self, void* ignored) {
  (void)ignored;
  const char* text = ((Course*)self)->report.problem;
  return PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
}

static PyMethodDef course_methods[] = {
  {"begin", begin, METH_VARARGS, begin_doc}, {"capture", capture, METH_NOARGS, capture_doc},
  {"memory", memory, METH_NOARGS, memory_doc}, {"read", read_now, METH_O, read_doc},
  {"write", write_now, METH_O, write_doc}, {NULL, NULL, 0, NULL},
};

static PyGetSetDef course_properties[] = {
  {"warnings", warnings_of, NULL, "Texts of MuJoCo's warnings in the last job.", NULL},
  {"problem", problem_of, NULL, "Text of MuJoCo's error in the last job.", NULL},
  {NULL, NULL, NULL, NULL, NULL},
};

#define REPORTED(member) (offsetof(Course, report) + offsetof(PhysicsReport, member))

static PyMemberDef course_members[] = {
  {"was_written", T_BOOL, offsetof(Course, was_written), READONLY, NULL},
  {"is_open", T_BOOL, offsetof(Course, is_open), READONLY, NULL},
  {"last_flags", T_INT, offsetof(Course, last_flags), READONLY, NULL},
  {"done", T_PYSSIZET, offsetof(Course, done), READONLY, NULL},
  {"outcome", T_INT, offsetof(Course, outcome), READONLY, NULL},
  {"error", T_OBJECT, offsetof(Course, error), READONLY, NULL},
  {"made", T_PYSSIZET, REPORTED(made), READONLY, NULL},
  {"seconds", T_DOUBLE, REPORTED(seconds), READONLY, NULL},
  {"has_diverged", T_BOOL, REPORTED(has_diverged), READONLY, NULL},
  {"is_finite", T_BOOL, REPORTED(is_finite), READONLY, NULL},
  {"has_deep_contacts", T_BOOL, REPORTED(has_deep_contacts), READONLY, NULL},
  {"is_rearranged", T_BOOL, offsetof(Course, is_rearranged), READONLY, NULL},
  {"has_overlaps", T_BOOL, offsetof(Course, has_overlaps), READONLY, NULL},
  {"is_captured", T_BOOL, offsetof(Course, is_captured), READONLY, NULL},
  {"steps", T_PYSSIZET, offsetof(Course, steps), READONLY, NULL},
  {"all_steps", T_PYSSIZET, offsetof(Course, all_steps), READONLY, NULL},
  {"restarts", T_PYSSIZET, offsetof(Course, restarts), READONLY, NULL},
  {NULL, 0, 0, 0, NULL},
};

static PyType_Slot course_slots[] = {
  {Py_tp_new, make_course}, {Py_tp_dealloc, forget_course}, {Py_tp_methods, course_methods},
  {Py_tp_members, course_members}, {Py_tp_getset, course_properties}, {0, NULL},
};

static PyType_Spec course_spec = {
  "simx_server.joints.native._crew.Course", sizeof(Course), 0, Py_TPFLAGS_DEFAULT, course_slots,
};

static PyTypeObject* course_type;


//------------------------------------------ the crew ----------------------------------------------

enum { STEP, RESTART, PHYSICS };

typedef struct Crew Crew;

typedef struct {
  Crew* crew;
  PyThread_type_lock wake;  /* released to call the thread, which waits for it */
  PyThread_type_lock ended; /* released by the thread at its end */
  char is_waiting;
} Worker;

struct Crew {
  PyObject_HEAD
  Py_ssize_t count;
  Course** courses; /* NULL: the place has none */

  Py_ssize_t worker_count;
  Worker* workers;
  Py_ssize_t started, allocated; /* threads, and pairs of locks */

  /* The job of all: of a call of step or restart. */
  int kind;
  const double* values;
  double* results;
  Py_ssize_t value_width, result_width, times;
  int* flags; /* for each place, of the physics of `submit` */

  /* Below the mutex. */
  PyThread_type_lock mutex;
  Py_ssize_t* queue; /* a ring of places that wait */
  Py_ssize_t first, waiting, at_once;
  Py_ssize_t running;
  Py_ssize_t* made; /* a ring of places whose physics is made */
  Py_ssize_t first_made, made_count;
  char caller_waits, is_ending;
  PyThread_type_lock ready; /* released for the caller that waits */

  char* is_out; /* for each place, whether a job of `submit` is in the queue, running or made */
  Py_ssize_t out;
  double each; /* seconds of a job, of the last ones */
  double cost[2]; /* seconds that the caller waits for a job, alone and with other threads; 0: not measured */
  unsigned calls; /* for which that decides */
};

static void do_job(Crew* crew, Py_ssize_t place, PyThreadState** thread) {
  Course* c = crew->courses[place];
  const double* values = crew->values ? crew->values + place * crew->value_width : NULL;
  double* results = crew->results ? crew->results + place * crew->result_width : NULL;
  switch (crew->kind) {
    case STEP:
      c->outcome = make_steps(c, values, results, crew->times, thread);
      break;
    case RESTART:
      c->outcome = start_again(c, values, results);
      break;
    default:
      c->outcome =
        physics->run(c->step, 0, c->substeps, c->substeps, PATIENCE, crew->flags[place], thread, &c->report);
  }
  if (c->outcome == EXCEPTION) {
    PyEval_RestoreThread(*thread);
    PyObject *type, *value, *trace;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    Py_XDECREF(c->error), Py_XDECREF(type), Py_XDECREF(trace);
    c->error = value;
    *thread = PyEval_SaveThread();
  }
}

/* Places that a thread has taken from the queue. */
typedef struct { Py_ssize_t first, number, place; } Taken;

/* Take the next places of the queue, with the mutex. */
static Taken take_places(Crew* crew) {
  Taken taken = {crew->first, crew->waiting < crew->at_once ? crew->waiting : crew->at_once, crew->queue[crew->first]};
  crew->first = (crew->first + taken.number) % crew->count;
  crew->waiting -= taken.number;
  crew->running += taken.number;
  return taken;
}

/* Take the last place of the queue, with the mutex: what Python has just done of its world is in this core's cache. */
static Taken take_newest(Crew* crew) {
  Py_ssize_t last = (crew->first + --crew->waiting) % crew->count;
  Taken taken = {last, 1, crew->queue[last]};
  crew->running++;
  return taken;
}

static void do_jobs(Crew* crew, const Taken* taken, PyThreadState** thread) {
  if (taken->number == 1) { /* its place in the queue may have another one meanwhile */
    do_job(crew, taken->place, thread);
    return;
  }
  for (Py_ssize_t i = 0; i < taken->number; i++) {
    do_job(crew, crew->queue[(taken->first + i) % crew->count], thread);
  }
}

/* Note that jobs are done, with the mutex. */
static void note_done(Crew* crew, const Taken* taken) {
  crew->running -= taken->number;
  if (crew->kind == PHYSICS) {
    crew->made[(crew->first_made + crew->made_count++) % crew->count] = taken->place;
  }
}

static void acquire(PyThread_type_lock lock) { PyThread_acquire_lock(lock, WAIT_LOCK); }

/* Acquire a lock that is released soon, or late. */
static void acquire_soon(PyThread_type_lock lock) {
  double end = seconds() + SPIN;
  do {
    for (int i = 0; i < LOOKS; i++) {
      if (PyThread_acquire_lock(lock, NOWAIT_LOCK)) {
        return;
      }
    }
  } while (seconds() < end);
  acquire(lock);
}

static void work(void* argument) {
  Worker* worker = argument;
  Crew* crew = worker->crew;
  PyGILState_STATE state = PyGILState_Ensure();
  PyThreadState* thread = PyEval_SaveThread();
  for (;;) {
    acquire(crew->mutex);
    while (crew->waiting) {
      Taken taken = take_places(crew);
      PyThread_release_lock(crew->mutex);
      do_jobs(crew, &taken, &thread);
      acquire(crew->mutex);
      note_done(crew, &taken);
      if (crew->caller_waits && (crew->kind == PHYSICS || !crew->running)) {
        crew->caller_waits = 0;
        PyThread_release_lock(crew->ready);
      }
    }
    if (crew->is_ending) {
      PyThread_release_lock(crew->mutex);
      break;
    }
    worker->is_waiting = 1;
    PyThread_release_lock(crew->mutex);
    acquire_soon(worker->wake);
  }
  PyEval_RestoreThread(thread);
  PyGILState_Release(state);
  PyThread_release_lock(worker->ended);
}

/* Start the threads; returns -1 with an exception. */
static int start_workers(Crew* crew) {
  for (; crew->started < crew->worker_count; crew->started++) {
    Worker* worker = crew->workers + crew->started;
    if (PyThread_start_new_thread(work, worker) == (unsigned long)-1) {
      PyErr_SetString(PyExc_RuntimeError, "a thread cannot be started");
      return -1;
    }
  }
  return 0;
}

/* Call up to this many threads that wait. */
static void call(Crew* crew, Py_ssize_t number) {
  for (Py_ssize_t i = 0; i < crew->started && number > 0; i++) {
    Worker* worker = crew->workers + i;
    acquire(crew->mutex);
    char is_waiting = worker->is_waiting;
    worker->is_waiting = 0;
    PyThread_release_lock(crew->mutex);
    if (is_waiting) {
      PyThread_release_lock(worker->wake);
      number--;
    }
  }
}

/* How jobs are made: alone or with other threads, and whether the time counts. */
typedef struct { char with_others, counts; } Way;

/* Choose the faster way, which is measured again and again: it depends on the work and on other programs. */
static Way choose(Crew* crew, Py_ssize_t number) {
  double work = crew->each * (double)number;
  if (number < 2 || !crew->worker_count || (work > 0 && work <= WORTHWHILE)) {
    return (Way){0, 0};
  }
  if (work == 0 || crew->kind != STEP) {
    return (Way){1, 0};
  }
  char better = crew->cost[1] != 0 && (crew->cost[0] == 0 || crew->cost[1] < crew->cost[0]);
  unsigned turn = crew->calls++ % PERIOD;
  return (Way){turn < TRIAL ? !better : better, turn >= WARM_UP && (turn < TRIAL || turn >= TRIAL + WARM_UP)};
}

static void average(double* mean, double new) { *mean = *mean == 0 ? new : 0.9 * *mean + 0.1 * fmin(new, 3 * *mean); }

/* Do the jobs of all places in the queue, together with the other threads if that is faster. */
static void do_all(Crew* crew, Py_ssize_t number) {
  double start = seconds();
  PyThreadState* thread = PyEval_SaveThread();
  Way way = choose(crew, number);
  if (way.with_others) {
    call(crew, number - 1);
  }
  Py_ssize_t done = 0;
  acquire(crew->mutex);
  while (crew->waiting) {
    Taken taken = take_places(crew);
    PyThread_release_lock(crew->mutex);
    do_jobs(crew, &taken, &thread);
    done += taken.number;
    acquire(crew->mutex);
    note_done(crew, &taken);
  }
  double end = seconds();
  while (crew->running) {
    crew->caller_waits = 1;
    PyThread_release_lock(crew->mutex);
    acquire_soon(crew->ready);
    acquire(crew->mutex);
  }
  PyThread_release_lock(crew->mutex);
  if (done && crew->kind == STEP) {
    average(&crew->each, (end - start) / (double)done);
  }
  if (way.counts) {
    average(&crew->cost[(int)way.with_others], (seconds() - start) / (double)number);
  }
  PyEval_RestoreThread(thread);
}

static int is_idle(Crew* crew) {
  if (crew->out) {
    PyErr_SetString(PyExc_RuntimeError, "physics is in progress");
  }
  return !crew->out;
}

/* Take the array with a row for each place; returns -1 with an exception. */
static int take_rows(Crew* crew, PyObject* array, Py_buffer* view, Py_ssize_t* width, int is_written) {
  if (PyObject_GetBuffer(array, view, is_written ? PyBUF_CONTIG : PyBUF_CONTIG_RO) < 0) {
    return -1;
  }
  *width = view->len / (Py_ssize_t)sizeof(double) / crew->count;
  if (view->itemsize != sizeof(double) || view->len != *width * crew->count * (Py_ssize_t)sizeof(double)) {
    PyErr_SetString(PyExc_ValueError, "an array does not have a row of numbers for each place");
    PyBuffer_Release(view);
    return -1;
  }
  return 0;
}

/* Put the places of an array into the queue; returns their number, -1 with an exception. */
static Py_ssize_t take_queue(Crew* crew, PyObject* array) {
  Py_buffer view;
  if (PyObject_GetBuffer(array, &view, PyBUF_CONTIG_RO) < 0) {
    return -1;
  }
  Py_ssize_t number = view.len / (Py_ssize_t)sizeof(Py_ssize_t);
  const Py_ssize_t* places = view.buf;
  int is_valid = view.itemsize == sizeof(Py_ssize_t) && number <= crew->count;
  for (Py_ssize_t i = 0; is_valid && i < number; i++) {
    Course* c = is_within(places[i], crew->count) ? crew->courses[places[i]] : NULL;
    is_valid = c && (i == 0 || places[i] > places[i - 1]) && crew->result_width >= c->reads.width &&
               crew->value_width >= (crew->kind == STEP ? c->writes.width : c->starts.width);
  }
  if (is_valid) {
    memcpy(crew->queue, places, (size_t)number * sizeof(Py_ssize_t));
  } else {
    PyErr_SetString(PyExc_ValueError, "places are numbers that rise, each with a course and rows that are wide enough");
  }
  PyBuffer_Release(&view);
  return is_valid ? number : -1;
}

/* Return the places whose job has not ended well. */
static PyObject* failed_places(Crew* crew, Py_ssize_t number) {
  PyObject* failed = PyList_New(0);
  for (Py_ssize_t i = 0; failed && i < number; i++) {
    if (crew->courses[crew->queue[i]]->outcome != WELL) {
      PyObject* place = PyLong_FromSsize_t(crew->queue[i]);
      if (!place || PyList_Append(failed, place) < 0) {
        Py_XDECREF(failed);
        failed = NULL;
      }
      Py_XDECREF(place);
    }
  }
  return failed;
}

static PyObject* together(Crew* crew, int kind, PyObject* places, PyObject* values, PyObject* results,
                          Py_ssize_t times) {
  Py_buffer given, found;
  if (!is_idle(crew) || start_workers(crew) < 0 || take_rows(crew, values, &given, &crew->value_width, 0) < 0) {
    return NULL;
  }
  PyObject* failed = NULL;
  if (take_rows(crew, results, &found, &crew->result_width, 1) == 0) {
    crew->kind = kind;
    Py_ssize_t number = take_queue(crew, places);
    if (number >= 0) {
      crew->values = given.buf, crew->results = found.buf, crew->times = times;
      Py_ssize_t shares = 4 * (crew->worker_count + 1);
      acquire(crew->mutex);
      crew->at_once = number > shares ? number / shares : 1;
      crew->first = 0, crew->waiting = number;
      PyThread_release_lock(crew->mutex);
      do_all(crew, number);
      failed = failed_places(crew, number);
    }
    PyBuffer_Release(&found);
  }
  PyBuffer_Release(&given);
  crew->values = NULL, crew->results = NULL;
  return failed;
}

PyDoc_STRVAR(step_doc, "step(places, values, results, times)\n\n"
"Write the values of some worlds, make simulation steps, and read the results. Returns the places whose job has not\n"
"ended well; see `Course.outcome`.");

static PyObject* step_all(PyObject* self, PyObject* args) {
  PyObject *places, *values, *results;
  Py_ssize_t times;
  if (!PyArg_ParseTuple(args, "OOOn", &places, &values, &results, &times)) {
    return NULL;
  }
  return together((Crew*)self, STEP, places, values, results, times);
}

PyDoc_STRVAR(restart_doc, "restart(places, values, results)\n\n"
"Start another episode in some worlds: restore what `Course.capture` has kept, write the values of the start, and read\n"
"the results. Returns the places whose job has not ended well.");

static PyObject* restart_all(PyObject* self, PyObject* args) {
  PyObject *places, *values, *results;
  if (!PyArg_ParseTuple(args, "OOO", &places, &values, &results)) {
    return NULL;
  }
  return together((Crew*)self, RESTART, places, values, results, 0);
}

PyDoc_STRVAR(submit_doc, "submit(place, flags)\n\nHave a thread make the physics of a simulation step of one world.");

static PyObject* submit(PyObject* self, PyObject* args) {
  Crew* crew = (Crew*)self;
  Py_ssize_t place;
  int flags;
  if (!PyArg_ParseTuple(args, "ni", &place, &flags) || start_workers(crew) < 0) {
    return NULL;
  }
  if (!is_within(place, crew->count) || !crew->courses[place] || crew->is_out[place]) {
    PyErr_SetString(PyExc_ValueError, "this place has no course, or its physics is in progress");
    return NULL;
  }
  crew->flags[place] = flags;
  crew->is_out[place] = 1;
  acquire(crew->mutex);
  if (!crew->out++) {
    crew->kind = PHYSICS, crew->at_once = 1, crew->first = 0, crew->first_made = 0;
  }
  crew->queue[(crew->first + crew->waiting++) % crew->count] = place;
  PyThread_release_lock(crew->mutex);
  call(crew, 1);
  Py_INCREF(Py_None);
  return Py_None;
}

PyDoc_STRVAR(next_doc, "next(most)\n\n"
"Return a place whose physics is made; -1: none is. While more than this number of places wait for a thread, this one\n"
"makes physics too; with a negative number it makes or awaits all that is in progress.");

static PyObject* next_made(PyObject* self, PyObject* args) {
  Crew* crew = (Crew*)self;
  Py_ssize_t most;
  if (!PyArg_ParseTuple(args, "n", &most)) {
    return NULL;
  }
  PyThreadState* thread = NULL;
  Py_ssize_t place = -1;
  acquire(crew->mutex);
  while (crew->out && !crew->made_count && crew->waiting > most) {
    if (!thread) {
      PyThread_release_lock(crew->mutex);
      thread = PyEval_SaveThread();
      acquire(crew->mutex);
    } else if (crew->waiting) {
      Taken taken = take_newest(crew);
      PyThread_release_lock(crew->mutex);
      do_jobs(crew, &taken, &thread);
      acquire(crew->mutex);
      note_done(crew, &taken);
    } else {
      crew->caller_waits = 1;
      PyThread_release_lock(crew->mutex);
      acquire_soon(crew->ready);
      acquire(crew->mutex);
    }
  }
  if (crew->made_count) {
    place = crew->made[crew->first_made];
    crew->first_made = (crew->first_made + 1) % crew->count;
    crew->made_count--;
    crew->out--;
    crew->is_out[place] = 0;
  }
  PyThread_release_lock(crew->mutex);
  if (thread) {
    PyEval_RestoreThread(thread);
  }
  return PyLong_FromSsize_t(place);
}

PyDoc_STRVAR(put_doc, "put(place, course)\n\nGive a place the course of its world; None: it has none.");

static PyObject* put(PyObject* self, PyObject* args) {
  Crew* crew = (Crew*)self;
  Py_ssize_t place;
  PyObject* course;
  if (!PyArg_ParseTuple(args, "nO", &place, &course)) {
    return NULL;
  }
  int fits = course == Py_None ? 1 : PyObject_IsInstance(course, (PyObject*)course_type);
  if (fits <= 0 || !is_within(place, crew->count) || crew->is_out[place]) {
    if (fits >= 0) {
      PyErr_SetString(PyExc_ValueError, "a course and a place of this crew are needed, whose physics is not in progress");
    }
    return NULL;
  }
  Py_XDECREF((PyObject*)crew->courses[place]);
  crew->courses[place] = NULL;
  if (course != Py_None) {
    Py_INCREF(course);
    crew->courses[place] = (Course*)course;
  }
  Py_INCREF(Py_None);
  return Py_None;
}

/* End the threads, and wait for them. */
static void end_workers(Crew* crew) {
  if (!crew->started) {
    return;
  }
  PyThreadState* thread = PyEval_SaveThread();
  acquire(crew->mutex);
  crew->is_ending = 1;
  PyThread_release_lock(crew->mutex);
  call(crew, crew->started);
  for (; crew->started; crew->started--) {
    acquire(crew->workers[crew->started - 1].ended);
  }
  PyEval_RestoreThread(thread);
}

PyDoc_STRVAR(close_doc, "close()\n\nEnd the threads. Idempotent; a later step is made by the caller's thread alone.");

static PyObject* close_crew(PyObject* self, PyObject* ignored) {
  (void)ignored;
  Crew* crew = (Crew*)self;
  if (!is_idle(crew)) {
    return NULL;
  }
  end_workers(crew);
  crew->worker_count = 0;
  Py_INCREF(Py_None);
  return Py_None;
}

/* Return a lock that is held; NULL without memory. */
static PyThread_type_lock held_lock(void) {
  PyThread_type_lock lock = PyThread_allocate_lock();
  if (lock) {
    acquire(lock);
  }
  return lock;
}

static PyObject* make_crew(PyTypeObject* type, PyObject* args, PyObject* keywords) {
  static char* names[] = {"count", "threads", NULL};
  Py_ssize_t count, threads;
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "nn", names, &count, &threads)) {
    return NULL;
  }
  if (count < 1 || threads < 1) {
    PyErr_SetString(PyExc_ValueError, "a crew has at least one place and one thread");
    return NULL;
  }
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  Crew* crew = (Crew*)allocate(type, 0); /* zeroed */
  if (!crew) {
    return NULL;
  }
  size_t places = (size_t)count;
  crew->count = count;
  crew->courses = calloc(places, sizeof(Course*));
  crew->flags = calloc(places, sizeof(int));
  crew->queue = calloc(places, sizeof(Py_ssize_t));
  crew->made = calloc(places, sizeof(Py_ssize_t));
  crew->is_out = calloc(places, 1);
  crew->workers = calloc((size_t)threads, sizeof(Worker));
  crew->mutex = PyThread_allocate_lock();
  crew->ready = held_lock();
  int is_complete = crew->courses && crew->flags && crew->queue && crew->made && crew->is_out && crew->workers &&
                    crew->mutex && crew->ready;
  for (; is_complete && crew->worker_count < threads - 1; crew->worker_count++) {
    Worker* worker = crew->workers + crew->worker_count;
    worker->crew = crew;
    worker->wake = held_lock(), worker->ended = held_lock();
    is_complete = worker->wake && worker->ended;
  }
  crew->allocated = crew->worker_count;
  if (!is_complete) {
    Py_DECREF((PyObject*)crew);
    return PyErr_NoMemory();
  }
  return (PyObject*)crew;
}

static void free_lock(PyThread_type_lock lock) {
  if (lock) {
    PyThread_free_lock(lock);
  }
}

static void forget_crew(PyObject* self) {
  Crew* crew = (Crew*)self;
  PyTypeObject* type = Py_TYPE(self);
  end_workers(crew);
  for (Py_ssize_t place = 0; crew->courses && place < crew->count; place++) {
    Py_XDECREF((PyObject*)crew->courses[place]);
  }
  for (Py_ssize_t i = 0; crew->workers && i < crew->allocated; i++) {
    free_lock(crew->workers[i].wake), free_lock(crew->workers[i].ended);
  }
  free_lock(crew->mutex), free_lock(crew->ready);
  free(crew->courses), free(crew->flags), free(crew->queue), free(crew->made), free(crew->is_out), free(crew->workers);
  freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
  release(self);
  Py_DECREF(type);
}

static PyMethodDef crew_methods[] = {
  {"step", step_all, METH_VARARGS, step_doc}, {"restart", restart_all, METH_VARARGS, restart_doc},
  {"submit", submit, METH_VARARGS, submit_doc}, {"next", next_made, METH_VARARGS, next_doc},
  {"put", put, METH_VARARGS, put_doc}, {"close", close_crew, METH_NOARGS, close_doc}, {NULL, NULL, 0, NULL},
};

static PyMemberDef crew_members[] = {
  {"workers", T_PYSSIZET, offsetof(Crew, started), READONLY, NULL},
  {NULL, 0, 0, 0, NULL},
};

static PyType_Slot crew_slots[] = {
  {Py_tp_new, make_crew}, {Py_tp_dealloc, forget_crew}, {Py_tp_methods, crew_methods}, {Py_tp_members, crew_members},
  {0, NULL},
};

static PyType_Spec crew_spec = {
  "simx_server.joints.native._crew.Crew", sizeof(Crew), 0, Py_TPFLAGS_DEFAULT, crew_slots,
};


//------------------------------------------ the module --------------------------------------------

PyDoc_STRVAR(connect_doc, "connect(addresses, physics_step, type)\n\n"
"Use the functions of the loaded MuJoCo, by name, the capsule of the module _physics_step, and its type of steps.");

static PyObject* connect(PyObject* module, PyObject* args) {
  (void)module;
  PyObject *addresses, *capsule, *type;
  if (!PyArg_ParseTuple(args, "O!OO", &PyDict_Type, &addresses, &capsule, &type)) {
    return NULL;
  }
  PhysicsStepApi* offered = PyCapsule_GetPointer(capsule, PHYSICS_STEP_API);
  if (!offered) {
    return NULL;
  }
  const Wanted wanted[] = {
    {"mj_resetData", (void**)&mj.resetData}, {"mj_stateSize", (void**)&mj.stateSize},
    {"mj_getState", (void**)&mj.getState}, {"mj_setState", (void**)&mj.setState},
  };
  if (take_addresses(addresses, wanted, sizeof(wanted) / sizeof(*wanted)) < 0) {
    return NULL;
  }
  Py_INCREF(type);
  Py_XDECREF(step_type);
  step_type = type, physics = offered;
  Py_INCREF(Py_None);
  return Py_None;
}

static PyMethodDef functions[] = {{"connect", connect, METH_VARARGS, connect_doc}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef definition = {
  PyModuleDef_HEAD_INIT, "_crew", "Worlds that step together in threads, compiled.", -1, functions, NULL, NULL, NULL,
  NULL,
};

#ifndef SOURCE_HASH
#define SOURCE_HASH ""
#endif

#define CONSTANT(module, name) (PyModule_AddIntConstant(module, #name, name) < 0)

PyMODINIT_FUNC PyInit__crew(void) {
  PyObject* module = PyModule_Create(&definition);
  PyObject* course = module ? PyType_FromSpec(&course_spec) : NULL;
  PyObject* crew = course ? PyType_FromSpec(&crew_spec) : NULL;
  if (!crew || PyModule_AddObjectRef(module, "Course", course) < 0 || PyModule_AddObjectRef(module, "Crew", crew) < 0 ||
      PyModule_AddIntConstant(module, "HEADER", mjVERSION_HEADER) < 0 || CONSTANT(module, WELL) ||
      CONSTANT(module, NO_ROOM) || CONSTANT(module, EXCEPTION) || CONSTANT(module, FAILED) ||
      CONSTANT(module, REFUSED) || CONSTANT(module, UNFINISHED) || CONSTANT(module, TARGET) ||
      CONSTANT(module, SPRING) || CONSTANT(module, CYCLIC_SPRING) || CONSTANT(module, COMMAND) || CONSTANT(module, FORCE) ||
      CONSTANT(module, PLACE) || CONSTANT(module, POSITION) || CONSTANT(module, LENGTH) || CONSTANT(module, RATE) || CONSTANT(module, MOTOR_FORCE) ||
      CONSTANT(module, BODY_POSITION) || CONSTANT(module, POSE_POSITION) || CONSTANT(module, POSE_QUATERNION) ||
      CONSTANT(module, POSE_ANGLES) || CONSTANT(module, VELOCITY) || CONSTANT(module, ANGULAR_VELOCITY) ||
      PyModule_AddStringConstant(module, "SOURCE_HASH", SOURCE_HASH) < 0) {
    Py_XDECREF(module);
    module = NULL;
  } else {
    Py_INCREF(course);
    course_type = (PyTypeObject*)course;
  }
  Py_XDECREF(course), Py_XDECREF(crew);
  return module;
}
