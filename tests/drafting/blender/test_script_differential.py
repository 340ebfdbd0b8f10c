"""Generated programs of the subset: the reader comes to the values that Python comes to."""

import re
from random import Random

import pytest
from script_reading import reads

from lidardraft.drafting.blender.script.limits import ScriptLimits

START = """import math, random
from collections import defaultdict, namedtuple
from contextlib import suppress
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import partial
from itertools import chain, combinations, count, cycle, pairwise, permutations, product, repeat
random.seed(7)
log, a, b, c = [], [3, 1, 2], [5, 4], {'x': 1, 'y': 2}
d, e, i, j, s = a, {'z': 3}, 2, -3, {1, 2}
t, u = s, defaultdict(list)
Q = namedtuple('Q', 'x y')
class K(Enum):
    ONE = 1
    TWO = auto()
@dataclass(order=True)
class P:
    x: int
    y: list = field(default_factory=list)
    made = 0
    def __post_init__(self):
        P.made += 1
    @property
    def double(self):
        return 2 * self.x
    @double.setter
    def double(self, value):
        self.x = value // 2
    def moved(self, n, *rest, by=1):
        return type(self)(self.x + n * by, [*self.y, *rest])
    @staticmethod
    def of(n):
        return R(n)
    def __repr__(self):
        return f'P{self.x}'
class R(P):
    def moved(self, n, *rest, by=1):
        return super().moved(n + 1, *rest, by=by)
p, q = P(4), R(5)
def f(n=1):
    log.append(n)
    return random.randrange(3) + n
def g(*rest, k=2, **more):
    return [*(each * k for each in rest), *more.values()]
def h(n):
    def inner():
        nonlocal n
        n += 1
        return n
    return inner() + inner()
"""
TEMPLATES = {
    "N": """i j 0 1 2 5 -3 (N+N) (N-N) (N*N%97) (N//N) (N%N) (N&N) (N|N) (N^N) (N<<N%5) (-N) (~N) f(N%5) h(N) L[N%4]
        c.get('x',N) (N_if_B_else_N) sum(L) len(L) len(T) max(L,default=N) min(N,N,key=abs) (i:=N) len(V) abs(N)
        sum(k*N_for_k_in_L_if_k>N) next(iter(L),N) divmod(N,7)[1] round(N/7) T.count('1') T.find('a') pow(N%5,2)
        P(N).moved(N,N,by=2).x R(N).moved(N).double O.x O.double K(2).value K.ONE.value
        next(count(N)) partial(max,N)(N) Q(N,y=N).y Q(N,N)[0] math.floor(N/3) int(str(N)) P.of(N).x
        len(V&V) len(V-V) u[N%2][:1].count(N) getattr(O,'x') (lambda_x,y=N:x-y)(N) random.choice([N,N])""",
    "L": """a b d [N,N] L[N%3:] L[::-1] list(range(N%5)) sorted(L,reverse=not_B) [k_for_k_in_L_if_B] [*L,N]
        list(g(*L,k=N,z=N)) list(map(abs,L)) list(filter(None,L)) [x-y_for_x,y_in_zip(L,L)]
        [x*k_for_k,x_in_enumerate(L,2)] list(chain(L,L)) list(map(max,cycle([1,N]),L))
        [x+y_for_x,y_in_product(L[:2],repeat=2)] list(c.values()) O.y [x-y_for_x,y_in_pairwise(L)] sorted(V)
        list(reversed(L)) (L+L) (L*(N%3)) [len(w)_for_w_in_T.split('1')]
        [x_for_y_in_[L,L]_for_x_in_y] list(map(len,[T,T])) list(repeat(N,2))
        [x*y_for_x,y_in_combinations(L[:4],2)] [k.value_for_k_in_K] u[N%2] [max(k)_for_k_in_permutations(L[:2])]
        list({k:N_for_k_in_L}) list(dict(zip(L,L)).values()) random.sample(L,1) list(O.moved(N,*L[:2]).y)""",
    "T": """'abc' str(N) repr(L) f'{i:>4}|{{{A}' f'{i!r}|{A}' ('%d_%s'%(N,L)) '{:03d}{}'.format(N,'ab')
        '-'.join(map(str,L)) T.upper() T.replace('1','xy') T[N%3:] (T+T) (T*(N%3)) T.strip('1') T.zfill(5) T.title()
        T.center(9,'*') str({1:N,'a':L}) str((N,)) str(O) f'{p}{q!r}' str([O]) str(c) f'{i/3:.2f}' T.rjust(4)
        ('%5.1f'%(N/3)) K(1).name str(K.TWO) repr(T) T.splitlines()[0]""",
    "B": """N<N N>=N N==N N!=N N_in_L T_in_T not_B (B_and_B) (B_or_B) N<=N<N L==L P(N)==P(N) O==O N_in_V any(L) O_in_[O]
        all(k<N_for_k_in_L) isinstance(O,R) isinstance(N,int) L T<T Q(N,N)==(N,N) hasattr(O,'z') K(1)_is_K.ONE
        'x'_in_c V.issubset(V) V==V (N,N)<(N,N) N_in_range(N) T.startswith('1')""",
    "V": """s t {N,2} set(L) (V|V) (V&V) (V-V) (V^V) V.union(L) V.difference(L,V) {k%3_for_k_in_L} V.copy()""",
    "O": """p q P(N) R(N) p.moved(N) P.of(N)""",
    "A": "a b d",
    "S": """A[N%3]+=N i+=N j-=N A+=L A*=N%3 A[N%3:]=L i,*A,j=N,*A,4 s|=V t&=V s-=V t^=V c|={'z':N} del_A[N%3] c[T[:1]]=N
        log.append(T) A=sorted(A) A.append(N) A.extend(L) A.insert(N%3,N) A.pop() A.remove(N) A.reverse()
        log.append(B) A.sort(key=lambda_k:-k) p.x+=N p.double=N q.y.append(N) s.add(N) s.discard(N) t.update(L,V)
        u[N%3].append(N) c.update(e,w=N) log.append(c.pop('w'))
        e.setdefault('y',N) log.append(O) i,j=j,i (i,[j,*A])=(N,[N,*L]) log.append([*g(*L)]) x=y=L p=O
        random.shuffle(A) log.append(P.made) assert_B log.append(round(random.uniform(N,5),6))
        log.append(random.choices(L,k=2)) log.append(sorted(c.items()))""",
}


def filled(r: Random, template: str, depth: int = 0) -> str:
    """A piece of a program, of which each letter for a kind of piece has become one of that kind."""

    def one(kind: re.Match[str]) -> str:
        known = TEMPLATES[kind[0]].split()
        return filled(r, r.choice(known[:4] if depth > 2 else known), depth + 1)

    return re.sub(r"(?<![\w.'])[NLTBVOAS](?![\w'])", one, template.replace("_", " "))


def statement(r: Random, depth: int = 0) -> list[str]:
    """The lines of a statement."""
    if depth > 1 or r.random() < 0.6:
        return [filled(r, "S")]
    body = ["    " + line for _ in range(r.randint(1, 3)) for line in statement(r, depth + 1)]
    heads = ["for i in L[:4]:", "if B:", "for i, k in zip(L, range(N % 4)):"]
    head = filled(r, r.choice(heads), 1)
    ends = r.choice([["else:", "    log.append('else')"], []])
    caught = ["except (IndexError, KeyError) as error:", "    log.append('missing')"]
    caught += ["else:", "    log.append('fine')", "finally:", "    log.append(i)"]
    if r.random() < 0.15:
        return ["with suppress(LookupError, ValueError):", *body]
    return ["try:", *body, *caught] if r.random() < 0.3 else [head, *body, *ends]


@pytest.mark.parametrize("seed", range(80))
def test_it_comes_to_what_python_comes_to(seed: int) -> None:
    r = Random(seed)
    lines = [START]
    for _ in range(12):
        lines += ["try:", *("    " + line for line in statement(r))]
        lines += ["except (LookupError, ArithmeticError, ValueError, AssertionError):", "    log.append('error')"]
    end = "found = repr((log, a, b, c, d, e, i, j, sorted(s), sorted(t), dict(u), p, q, p.y, random.random()))"
    names: dict[str, object] = {"__name__": "__main__"}
    program = "\n".join([*lines, end])
    exec(compile(program, "program", "exec"), names)
    reads(f"{program}\nassert found == {names['found']!r}, found", ScriptLimits(steps=10**6))
